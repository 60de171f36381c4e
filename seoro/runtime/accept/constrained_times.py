"""Constraints on the times of a behavior: `duration`, `overlap` and offsets of `it` (7.3.13)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import chain
from typing import Final, cast

from seoro.lang import plan as plan_

_TIMES: Final = frozenset({"duration", "overlap", "start_to_start", "end_to_end"})


def times_in(expression: plan_.Expression) -> frozenset[str]:
    """Return the times of `it` in an expression."""
    return frozenset(cast(plan_.Member, part).name for part in plan_.walk(expression) if is_time(part))


def has_times(behavior: plan_.Behavior | None, applied: Iterable[object], plan: plan_.Plan) -> bool:
    """Whether constraints affect times of a behavior: its own, those of its modifiers, or of held objects."""
    members: list[object] = list(getattr(behavior, "constraints", ()))
    held = (each for type_ in plan.objects.values() for each in type_.modifiers)
    pending = [each for each in chain(applied, held) if isinstance(each, plan_.ModifierApplication)]
    while pending:
        modifier = plan.modifiers[pending.pop().modifier]
        members += modifier.structure.members
        pending += [each for each in modifier.modifiers if isinstance(each, plan_.ModifierApplication)]
    return any(times_in(expression) for expression in expressions_of(members))


def expressions_of(members: Iterable[object]) -> Iterator[plan_.Expression]:
    """Yield the conditions and defaults among members of a declaration."""
    for member in members:
        if isinstance(member, plan_.Constraint):
            yield member.condition
        elif isinstance(member, plan_.FieldDeclaration) and member.default is not None:
            yield member.default


def is_time(expression: plan_.Expression) -> bool:
    """Whether an expression is a time of `it`."""
    return (
        isinstance(expression, plan_.Member)
        and expression.name in _TIMES
        and isinstance(expression.base, plan_.Binding)
        and expression.base.name == "it"
    )
