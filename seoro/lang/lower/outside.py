"""Constraints from outside on parameters of the entry scenario (`pace in [2mps..3mps]`) and of its invocations.

They are expressions in the scope of the scenario, in which the name of an invocation leads to its parameters:
`drive.speed in [1mps..2mps]`. They come after all others, so that they replace defaults.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from seoro.lang import ast, plan
from seoro.lang.check.constraints import paths_in
from seoro.lang.check.expressions import Expressions
from seoro.lang.check.scopes import Scope
from seoro.lang.diagnostic import Bag
from seoro.lang.frozen import Value
from seoro.lang.parser import parse_expression
from seoro.lang.source import SourceFile, Span
from seoro.lang.symbols import Structured, TypeSymbol

ORIGIN = "<constraint>"


class OutsideConstraint(Value):
    """Constraint from outside.

    Args:
        invocation: Name of the invocation that it is about; empty for the scenario.
        paths: Paths of the parameters in it.
        constraint: The constraint.
    """

    invocation: str
    paths: tuple[str, ...]
    constraint: plan.Constraint


def outside_constraints(
    texts: Sequence[str], expressions: Expressions, scope: Scope, bag: Bag, invoked: Mapping[str, TypeSymbol]
) -> tuple[OutsideConstraint, ...]:
    """Convert texts to constraints; invalid ones are reported.

    Args:
        texts: The constraints, as boolean expressions.
        expressions: Checker of expressions.
        scope: The scope of the scenario.
        bag: Bag for messages.
        invoked: Invoked scenarios and actions, by the names of the invocations.
    """
    found = (_converted(text, expressions, scope, bag, invoked) for text in texts)
    return tuple(each for each in found if each is not None)


def _converted(
    text: str, expressions: Expressions, scope: Scope, bag: Bag, invoked: Mapping[str, TypeSymbol]
) -> OutsideConstraint | None:
    file = SourceFile(ORIGIN, text)
    node = parse_expression(file, bag)
    if node is None:
        return None
    names = (name for name in _roots(node) if name in invoked and name not in scope.fields)
    invocation = next(names, "")
    if invocation:
        node = _with_it(node, invocation)
        scope = replace(scope, it=Structured(invoked[invocation]), is_it_bound=True)
    else:
        scope = replace(scope, invoked=tuple(invoked))
    keep = ast.KeepConstraint(None, node, Span(file, 0, len(text)))
    for constraint in expressions.constraints.among((keep,), scope):
        assert isinstance(constraint, plan.Constraint), "not a `remove_default`"
        found = paths_in(constraint.condition, scope, expressions.program)
        paths = (".".join(field.name for field in fields) for _, fields in found)
        return OutsideConstraint(invocation, tuple(paths), constraint)
    return None


def _roots(node: ast.Expression) -> Iterator[str]:
    """Yield what may be names of invocations: the texts before a dot."""
    match node:
        case ast.FieldAccess(base):
            yield base.span.text
            yield from _roots(base)
        case ast.Relation(_, left, right) | ast.Logic(_, left, right) | ast.Arithmetic(_, left, right):
            yield from _roots(left)
            yield from _roots(right)
        case ast.Negation(operand) | ast.Inversion(operand):
            yield from _roots(operand)
        case _:
            pass


def _with_it(node: ast.Expression, name: str) -> ast.Expression:
    """Replace the name of an invocation by `it`."""
    match node:
        case ast.FieldAccess(base):
            inside = ast.It(base.span) if base.span.text == name else _with_it(base, name)
            return replace(node, base=inside)
        case ast.Relation() | ast.Logic() | ast.Arithmetic():
            return replace(node, left=_with_it(node.left, name), right=_with_it(node.right, name))
        case ast.Negation() | ast.Inversion():
            return replace(node, operand=_with_it(node.operand, name))
        case _:
            return node
