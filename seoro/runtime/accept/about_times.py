"""Which constraints are about the times of a behavior: `duration`, `overlap` and offsets of `it` (7.3.13)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import chain
from typing import Final, cast

from seoro.lang.plan import (
    Behavior,
    Binding,
    Constraint,
    Expression,
    FieldDeclaration,
    Member,
    ModifierApplication,
    Plan,
    parts,
)

_TIMES: Final = frozenset({"duration", "overlap", "start_to_start", "end_to_end"})


def times_in(expression: Expression) -> frozenset[str]:
    """The times of `it` in an expression."""
    found: set[str] = set()
    pending = [expression]
    while pending:
        part = pending.pop()
        if is_time(part):
            found.add(cast(Member, part).name)
        pending += parts(part)
    return frozenset(found)


def has_times(behavior: Behavior | None, applied: Iterable[object], plan: Plan) -> bool:
    """Whether constraints are about times of a behavior: its own, those of its modifiers, or of what it holds."""
    members: list[object] = list(getattr(behavior, "constraints", ()))
    held = (each for type_ in plan.objects.values() for each in type_.modifiers)
    pending = [each for each in chain(applied, held) if isinstance(each, ModifierApplication)]
    while pending:
        modifier = plan.modifiers[pending.pop().modifier]
        members += modifier.structure.members
        pending += [each for each in modifier.modifiers if isinstance(each, ModifierApplication)]
    return any(times_in(expression) for expression in expressions_of(members))


def expressions_of(members: Iterable[object]) -> Iterator[Expression]:
    """The conditions and defaults among the members of something."""
    for member in members:
        if isinstance(member, Constraint):
            yield member.condition
        elif isinstance(member, FieldDeclaration) and member.default is not None:
            yield member.default


def is_time(expression: Expression) -> bool:
    """Whether an expression is one of the times of `it`."""
    return (
        isinstance(expression, Member)
        and expression.name in _TIMES
        and isinstance(expression.base, Binding)
        and expression.base.name == "it"
    )
