"""Traversal of expressions of the plan, and of graphs of names."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

from seoro.lang import plan

Implementations = Callable[[str], Iterable[plan.Method]]


def names_used(
    expression: plan.Expression, implementations: Implementations, structures: plan.Structures
) -> set[str]:
    """Return the fields of the own instance and the global parameters that an expression may read.

    Args:
        expression: The expression.
        implementations: Returns all implementations of a method.
        structures: The structures of all types.
    """
    found: set[str] = set()
    seen: set[tuple[str, bool]] = set()
    pending = [(expression, True)]  # with whether it has the scope of the expression
    while pending:
        current, is_own = pending.pop()
        pending.extend((part, is_own) for part in plan.parts(current))
        match current:
            case plan.Field(name) if is_own:
                found.add(name)
            case plan.Global(name):
                found.add(name)
            case plan.Construct(type_) if (type_.name, False) not in seen:
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
    """Yield the default values of fields, including latent subtypes."""
    members = (*structure.members, *(member for latent in structure.latents for member in latent.members))
    for member in members:
        if isinstance(member, plan.FieldDeclaration) and member.default is not None:
            yield member.default


def _bodies(method: plan.Method) -> Iterable[plan.Expression]:
    """Yield the expressions of a method."""
    yield from (default for _, default in method.parameters if default is not None)
    match method.body:
        case plan.External(_, positional, named):
            yield from (argument.value for argument in positional)
            yield from (argument.value for _, argument in named)
        case plan.Undefined():
            pass
        case body:
            yield body


def inner_first(expression: plan.Expression) -> list[plan.Expression]:
    """Return an expression and its parts in source order, inner parts first."""
    found: list[plan.Expression] = []
    pending = [expression]
    while pending:
        found.append(pending.pop())
        pending += plan.parts(found[-1])
    return found[::-1]


def circles(edges: Mapping[str, Sequence[str]]) -> Iterator[tuple[str, ...]]:
    """Yield cycles of a graph of names, one per strongly connected part."""
    done: set[str] = set()
    for first in edges:
        path = {first: iter(edges[first])} if first not in done else {}
        while path:
            following = next((name for name in path[next(reversed(path))] if name not in done), None)
            if following is None:
                done.add(path.popitem()[0])
            elif following in path:
                order = list(path)
                yield (*order[order.index(following) :], following)
                done.update(path)
                break
            else:
                path[following] = iter(edges[following])
