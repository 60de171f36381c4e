"""Constraints on the times of a behavior: `duration`, `overlap` and offsets of `it` (7.3.13)."""

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
    walk,
)

_TIMES: Final = frozenset({"duration", "overlap", "start_to_start", "end_to_end"})


def times_in(expression: Expression) -> frozenset[str]:
    """Return the times of `it` in an expression."""
    return frozenset(cast(Member, part).name for part in walk(expression) if is_time(part))


def has_times(behavior: Behavior | None, applied: Iterable[object], plan: Plan) -> bool:
    """Whether constraints affect times of a behavior: its own, those of its modifiers, or of held objects."""
    members: list[object] = list(getattr(behavior, "constraints", ()))
    held = (each for type_ in plan.objects.values() for each in type_.modifiers)
    pending = [each for each in chain(applied, held) if isinstance(each, ModifierApplication)]
    while pending:
        modifier = plan.modifiers[pending.pop().modifier]
        members += modifier.structure.members
        pending += [each for each in modifier.modifiers if isinstance(each, ModifierApplication)]
    return any(times_in(expression) for expression in expressions_of(members))


def expressions_of(members: Iterable[object]) -> Iterator[Expression]:
    """Yield the conditions and defaults among members of a declaration."""
    for member in members:
        if isinstance(member, Constraint):
            yield member.condition
        elif isinstance(member, FieldDeclaration) and member.default is not None:
            yield member.default


def is_time(expression: Expression) -> bool:
    """Whether an expression is a time of `it`."""
    return (
        isinstance(expression, Member)
        and expression.name in _TIMES
        and isinstance(expression.base, Binding)
        and expression.base.name == "it"
    )
