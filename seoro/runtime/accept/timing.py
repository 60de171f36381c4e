"""The times that constraints leave to a behavior: `duration`, `overlap` and offsets of `it` (7.3.13, 7.6.2.4).

What constraints leave open about a time is decided while the behavior runs. So the trace has to keep within a
window: from the least to the most that any values leave which meet all hard constraints. These compare times with
other values; between the values that occur in them nothing changes, so that it is enough to try those, and what
lies a nanosecond beside them. Constraints that compute with times are not decided.
"""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import product
from math import inf
from typing import Final, cast

from seoro.lang.plan import (
    Behavior,
    Bound,
    Compare,
    Constraint,
    ConstraintMember,
    Contains,
    EnumType,
    EnumValue,
    Expression,
    Logic,
    Not,
    Overlap,
)
from seoro.runtime.accept.about_times import expressions_of, is_time, times_in
from seoro.runtime.accept.findings import Undecided
from seoro.runtime.accept.frames import Frame, Matched
from seoro.runtime.accept.world import Instance, World
from seoro.runtime.environment import Environment
from seoro.runtime.values import HasFields, Range, Value

_FOREVER: Final = 1e9  # [s]; no constraint asks for more
_BESIDE: Final = 1e-9  # [s]
_MOST: Final = 24  # values to try
_KINDS: Final = EnumType("overlap_kind", tuple((kind.value, number) for number, kind in enumerate(Overlap)))


@dataclass(frozen=True, eq=False)
class _It:
    """What is modified, with its times."""

    types: tuple[str, ...]
    fields: ChainMap[str, Value]


@dataclass(frozen=True, eq=False)
class Said:
    """A constraint on times, where it applies.

    Args:
        constraint: The constraint.
        environment: What names stand for in it, but for `it`.
        names: The times that it is about.
    """

    constraint: Constraint
    environment: Environment
    names: frozenset[str]


@dataclass(frozen=True)
class Window:
    """What constraints leave of a duration.

    Args:
        bounds: The least and the most [s].
        is_all: Whether all between is left, so that nothing else ends what is carried out.
    """

    bounds: Range
    is_all: bool


@dataclass(eq=False)
class Timing:
    """Finds what constraints leave.

    Args:
        world: The values of the trace.
        matched: The modifiers that were found.
    """

    world: World
    matched: Matched

    def said(self, behavior: Behavior | None, frame: Frame, it: Instance | None) -> list[Said]:
        """The constraints on times of what is carried out in a frame.

        Raises:
            Undecided: The trace does not tell of the values of a modifier.
        """
        if it is not None and "duration" in it.declaration.structure.fields:
            return []
        found = list(self._of(getattr(behavior, "constraints", ()), frame.around.environment))
        for application, modifier, node, environment in self.matched.modifiers:
            if node.owner is not frame.owner or node.end.seq < frame.start.seq or node.start.seq > frame.end.seq:
                continue
            if not any(times_in(each) for each in expressions_of(modifier.structure.members)):
                continue
            fields = {name: self.world.decode(value) for name, value in node.arguments.items()}
            bindings: dict[str, Value | HasFields] = {}
            if application.actor is not None:
                bindings["actor"] = self.world.value(application.actor, environment, frame.start.seq)
            holder = cast(HasFields, _It((), ChainMap(fields)))
            found += self._of(
                modifier.structure.members, Environment(holder, bindings, scenario=environment.outermost)
            )
        return found

    def _of(self, members: Iterable[ConstraintMember | object], environment: Environment) -> Iterator[Said]:
        for member in members:
            if isinstance(member, Constraint) and (names := times_in(member.condition)):
                yield Said(member, environment, names)

    def duration(self, behavior: Behavior | None, frame: Frame, it: Instance | None) -> Window | None:
        """What constraints leave of the duration [s]; None if none that is decided is about it.

        Raises:
            Undecided: The trace does not tell.
        """
        said = [each for each in self.said(behavior, frame, it) if "duration" in each.names]
        hard = [each for each in said if not each.constraint.is_default]
        if not hard:
            return Window(Range(0.0, inf), is_all=False) if said else None
        is_all, said = len(hard) == len(said), hard
        values = self._values(said, it, frame)
        pairs = ((low, high) for low, high in product(values, values) if low <= high)
        found = [
            Range(low, high) for low, high in pairs if self._holds(said, it, frame, {"duration": Range(low, high)})
        ]
        if not found:
            raise Undecided("no duration meets all constraints")
        high = max(each.high for each in found)
        lows, highs = ({getattr(each, side) for each in found} for side in ("low", "high"))
        is_all = is_all and len(found) == sum(least <= most for least, most in product(lows, highs))
        return Window(Range(min(lows), inf if high >= _FOREVER else high), is_all)

    def offset(self, name: str, behavior: Behavior, frame: Frame) -> Range | None:
        """What constraints leave of an offset [s]; None if none is about it.

        Raises:
            Undecided: The trace does not tell.
        """
        said = self._all_of(name, behavior, frame)
        if not said:
            return None
        values = self._values(said, None, frame)
        found = [value for value in values if self._holds(said, None, frame, {name: value})]
        if not found:
            raise Undecided(f"no value of `{name}` meets all constraints")
        low, high = min(found), max(found)
        return Range(-inf if low <= -_FOREVER else low, inf if high >= _FOREVER else high)

    def overlap(self, behavior: Behavior, frame: Frame) -> Overlap | None:
        """The kind of overlap that constraints leave; None if none is about it.

        Raises:
            Undecided: They leave several, or the trace does not tell.
        """
        said = self._all_of("overlap", behavior, frame)
        if not said:
            return None
        found = [kind for kind in Overlap if self._holds(said, None, frame, {"overlap": _kind(kind)})]
        if len(found) != 1:
            raise Undecided("constraints leave several kinds of `overlap`")
        return found[0]

    def _all_of(self, name: str, behavior: Behavior, frame: Frame) -> list[Said]:
        said = [each for each in self.said(behavior, frame, None) if name in each.names]
        if any(each.names != {name} or each.constraint.is_default for each in said):
            raise Undecided(f"constraints on `{name}` that others may override, or that are about more than it")
        return said

    # -------------------------------------------------------- what meets constraints

    def _holds(self, said: list[Said], it: Instance | None, frame: Frame, times: dict[str, Value]) -> bool:
        shown = _It((), ChainMap(times)) if it is None else _It(it.types, ChainMap(times, it.fields))
        seq = max(frame.start.seq, it.seq + 1) if it is not None else frame.start.seq
        for each in said:
            bindings = {**each.environment.bindings, "it": cast(HasFields, shown)}
            if not self.world.value(each.constraint.condition, replace(each.environment, bindings=bindings), seq):
                return False
        return True

    def _values(self, said: list[Said], it: Instance | None, frame: Frame) -> list[float]:
        """The times at which it may change whether constraints hold [s]."""
        found = {0.0, -_FOREVER, _FOREVER}
        seq = max(frame.start.seq, it.seq + 1) if it is not None else frame.start.seq
        for each in said:
            if not _only_compares(each.constraint.condition):
                raise Undecided("a constraint computes with times")
            bindings = dict(each.environment.bindings)
            if it is not None:
                bindings["it"] = it
            environment = replace(each.environment, bindings=bindings)
            for operand in _operands(each.constraint.condition):
                value = self.world.value(operand, environment, seq)
                bounds = [value.low, value.high] if isinstance(value, Range) else [value]
                numbers = (float(bound) for bound in bounds if isinstance(bound, int | float))
                found.update(number + beside for number in numbers for beside in (-_BESIDE, 0.0, _BESIDE))
        if len(found) > _MOST:
            raise Undecided("too many constraints are about times")
        if said and said[0].names == {"duration"}:
            found = {value for value in found if value >= 0}
        return sorted(found)


def _only_compares(expression: Expression) -> bool:
    """Whether times in a condition are only compared, as they are."""
    match expression:
        case Logic(_, left, right):
            return _only_compares(left) and _only_compares(right)
        case Not(operand):
            return _only_compares(operand)
        case Compare(_, left, right) | Contains(left, right):
            return all(_is_bare(each) or not times_in(each) for each in (left, right))
        case _:
            return not times_in(expression)


def _operands(expression: Expression) -> Iterator[Expression]:
    """What a condition compares with times."""
    match expression:
        case Logic(_, left, right):
            yield from _operands(left)
            yield from _operands(right)
        case Not(operand):
            yield from _operands(operand)
        case Compare(_, left, right) | Contains(left, right) if times_in(expression):
            yield from (each for each in (left, right) if not _is_bare(each))
        case _:
            pass


def _is_bare(expression: Expression) -> bool:
    return is_time(expression) or (isinstance(expression, Bound) and is_time(expression.range))


def _kind(kind: Overlap) -> EnumValue:
    return EnumValue(_KINDS.name, kind.value, dict(_KINDS.members)[kind.value])
