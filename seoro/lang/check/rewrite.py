"""Walks over expressions of the plan: what they refer to, and replacing it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from typing import assert_never

from seoro.lang import plan

_Operation = plan.Arithmetic | plan.Concatenate | plan.Compare | plan.Logic
Implementations = Callable[[str], Iterable[plan.Method]]


def names_used(expression: plan.Expression, implementations: Implementations) -> set[str]:
    """Names of the fields that an expression reads, of the instance in whose scope it stands, and of all global
    parameters that it may read.

    Args:
        expression: The expression.
        implementations: All implementations of a method.
    """
    found: set[str] = set()
    seen: set[tuple[str, bool]] = set()
    pending = [(expression, True)]  # with whether its scope is that of the expression
    while pending:
        current, is_own = pending.pop()
        pending.extend((part, is_own) for part in plan.parts(current))
        match current:
            case plan.Field(name) if is_own:
                found.add(name)
            case plan.Global(name):
                found.add(name)
            case plan.Construct(type_, structures=structures) if (type_.name, False) not in seen:
                seen.add((type_.name, False))
                pending.extend((value, False) for value in _defaults(structures.of(type_)))
            case plan.Call(receiver, method) if (method, is_own and receiver is None) not in seen:
                seen.add((method, is_own and receiver is None))
                bodies = (body for each in implementations(method) for body in _bodies(each))
                pending.extend((body, is_own and receiver is None) for body in bodies)
            case _:
                pass
    return found


def _defaults(structure: plan.Structure) -> Iterable[plan.Expression]:
    """The default values of fields, those of latent subtypes included."""
    members = (*structure.members, *(member for latent in structure.latents for member in latent.members))
    for member in members:
        if isinstance(member, plan.FieldDeclaration) and member.default is not None:
            yield member.default


def _bodies(method: plan.Method) -> Iterable[plan.Expression]:
    """The expressions of a method."""
    yield from (default for _, default in method.parameters if default is not None)
    match method.body:
        case plan.External(_, positional, named):
            yield from (argument.value for argument in positional)
            yield from (argument.value for _, argument in named)
        case plan.Undefined():
            pass
        case body:
            yield body


def substitute(expression: plan.Expression, fields: Mapping[str, plan.Expression]) -> plan.Expression:
    """The expression with values in the place of fields."""

    def put(node: plan.Expression) -> plan.Expression:
        return fields.get(node.name, node) if isinstance(node, plan.Field) else node

    return rewrite(expression, put)


def rewrite(expression: plan.Expression, visit: Callable[[plan.Expression], plan.Expression]) -> plan.Expression:
    """The expression with each part replaced by what `visit` makes of it, inner ones first.

    What the structures of constructed values say has a scope of its own and stays as it is.
    """

    def go(inner: plan.Expression) -> plan.Expression:
        return rewrite(inner, visit)

    def go_all(inner: tuple[plan.Expression, ...]) -> tuple[plan.Expression, ...]:
        return tuple(rewrite(each, visit) for each in inner)

    def go_named(inner: tuple[tuple[str, plan.Expression], ...]) -> tuple[tuple[str, plan.Expression], ...]:
        return tuple((name, rewrite(value, visit)) for name, value in inner)

    match expression:
        case plan.Literal() | plan.Field() | plan.Binding() | plan.Labelled() | plan.Self() | plan.Global():
            return visit(expression)
        case plan.Member(base):
            return visit(replace(expression, base=go(base)))
        case plan.Negate(operand) | plan.Not(operand) | plan.Convert(operand):
            return visit(replace(expression, operand=go(operand)))
        case plan.TypeTest(operand) | plan.Cast(operand):
            return visit(replace(expression, operand=go(operand)))
        case plan.Arithmetic() | plan.Concatenate() | plan.Compare() | plan.Logic():
            return _rewrite_chain(expression, visit)
        case plan.Contains(item, container):
            return visit(replace(expression, item=go(item), container=go(container)))
        case plan.Conditional():
            return _rewrite_table(expression, visit)
        case plan.ListOf(items):
            return visit(replace(expression, items=go_all(items)))
        case plan.Join(lists):
            return visit(replace(expression, lists=go_all(lists)))
        case plan.ForEach(_, items, body):
            return visit(replace(expression, items=go(items), body=go(body)))
        case plan.Size(items):
            return visit(replace(expression, items=go(items)))
        case plan.Bound(_, bounds):
            return visit(replace(expression, range=go(bounds)))
        case plan.StringCall(_, text, arguments):
            return visit(replace(expression, text=go(text), arguments=go_all(arguments)))
        case plan.RangeOf(low, high):
            return visit(replace(expression, low=go(low), high=go(high)))
        case plan.Index(items, position):
            return visit(replace(expression, items=go(items), position=go(position)))
        case plan.Reference(path):
            return visit(replace(expression, path=go(path)))
        case plan.Construct(arguments=given):
            return visit(replace(expression, arguments=go_named(given)))
        case plan.Call(receiver, arguments=given):
            of = go(receiver) if receiver is not None else None
            return visit(replace(expression, receiver=of, arguments=go_named(given)))
        case _:
            assert_never(expression)


def _rewrite_chain(expression: _Operation, visit: Callable[[plan.Expression], plan.Expression]) -> plan.Expression:
    """A chain of operators, from its left end: chains may be long, so they are no recursion."""
    chain = [expression]
    while isinstance(left := chain[-1].left, _Operation):
        chain.append(left)
    done = rewrite(chain[-1].left, visit)
    for step in reversed(chain):
        done = visit(replace(step, left=done, right=rewrite(step.right, visit)))
    return done


def _rewrite_table(
    expression: plan.Conditional, visit: Callable[[plan.Expression], plan.Expression]
) -> plan.Expression:
    """`? :` with more on its last branch, from there: there may be many, so they are no recursion."""
    rows = [expression]
    while isinstance(last := rows[-1].otherwise, plan.Conditional):
        rows.append(last)
    done = rewrite(last, visit)
    for row in reversed(rows):
        condition, then = rewrite(row.condition, visit), rewrite(row.then, visit)
        done = visit(replace(row, condition=condition, then=then, otherwise=done))
    return done
