"""Times that constraints leave to a behavior: `duration`, `overlap` and offsets of `it` (7.3.13, 7.6.2.4).

The run decides about times that constraints leave open. The trace therefore has to keep within a window: from the
minimum to the maximum of all values that meet the hard constraints. These compare times with other values, and
nothing changes between the compared values: it is enough to try those values, and those a nanosecond beside them.
Constraints that compute with times are not decided.
"""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import product
from math import inf
from typing import Final

from seoro.lang import plan
from seoro.runtime.accept.findings import Undecided
from seoro.runtime.accept.frames import Frame, Matched
from seoro.runtime.accept.instances import Holder, Instance
from seoro.runtime.accept.layers import expressions_of, is_time, times_in
from seoro.runtime.accept.world import World
from seoro.runtime.values.environment import Environment
from seoro.runtime.values.values import HasFields, Range, Value

_FOREVER: Final = 1e9  # [s]; upper limit of all times
_BESIDE: Final = 1e-9  # [s]
_MOST: Final = 24  # values to try
_KINDS: Final = {
    kind: plan.EnumValue("overlap_kind", kind.value, number) for number, kind in enumerate(plan.Overlap)
}


@dataclass(frozen=True, eq=False)
class TimeConstraint:
    """A constraint on times in its context.

    Args:
        constraint: The constraint.
        environment: Its environment, without `it`.
        names: The times that it bounds.
    """

    constraint: plan.Constraint
    environment: Environment
    names: frozenset[str]


@dataclass(frozen=True)
class Window:
    """Permitted durations.

    Args:
        bounds: Minimum and maximum [s].
        is_all: Whether all values between are permitted, so that nothing else ends the behavior.
    """

    bounds: Range
    is_all: bool


@dataclass(eq=False)
class Timing:
    """Finds permitted times.

    Args:
        world: Values of the trace.
        matched: Matched modifiers.
    """

    world: World
    matched: Matched

    def constraints_on(
        self, behavior: plan.Behavior | None, frame: Frame, it: Instance | None
    ) -> list[TimeConstraint]:
        """Return the constraints on times of the content of a frame.

        Raises:
            Undecided: The trace lacks the values of a modifier.
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
            holder = Holder((), fields)
            found += self._of(
                modifier.structure.members,
                Environment(holder, environment.plan, bindings, scenario=environment.outermost),
            )
        return found

    def _of(
        self, members: Iterable[plan.ConstraintMember | object], environment: Environment
    ) -> Iterator[TimeConstraint]:
        for member in members:
            if isinstance(member, plan.Constraint) and (names := times_in(member.condition)):
                yield TimeConstraint(member, environment, names)

    def duration(self, behavior: plan.Behavior | None, frame: Frame, it: Instance | None) -> Window | None:
        """Return the permitted durations; None without a decided constraint.

        Raises:
            Undecided: The trace lacks the data.
        """
        constraints = [each for each in self.constraints_on(behavior, frame, it) if "duration" in each.names]
        hard = [each for each in constraints if not each.constraint.is_default]
        if not hard:
            return Window(Range(0.0, inf), is_all=False) if constraints else None
        is_all, constraints = len(hard) == len(constraints), hard
        values = self._values(constraints, it, frame)
        pairs = ((low, high) for low, high in product(values, values) if low <= high)
        found = [
            Range(low, high)
            for low, high in pairs
            if self._holds(constraints, it, frame, {"duration": Range(low, high)})
        ]
        if not found:
            raise Undecided("no duration meets all constraints")
        high = max(each.high for each in found)
        lows, highs = ({getattr(each, side) for each in found} for side in ("low", "high"))
        is_all = is_all and len(found) == sum(least <= most for least, most in product(lows, highs))
        return Window(Range(min(lows), inf if high >= _FOREVER else high), is_all)

    def offset(self, name: str, behavior: plan.Behavior, frame: Frame) -> Range | None:
        """Return the permitted values of an offset [s]; None without a constraint.

        Raises:
            Undecided: The trace lacks the data.
        """
        constraints = self._all_of(name, behavior, frame)
        if not constraints:
            return None
        values = self._values(constraints, None, frame)
        found = [value for value in values if self._holds(constraints, None, frame, {name: value})]
        if not found:
            raise Undecided(f"no value of `{name}` meets all constraints")
        low, high = min(found), max(found)
        return Range(-inf if low <= -_FOREVER else low, inf if high >= _FOREVER else high)

    def overlap(self, behavior: plan.Behavior, frame: Frame) -> plan.Overlap | None:
        """Return the permitted kind of overlap; None without a constraint.

        Raises:
            Undecided: Several kinds are permitted, or the trace lacks the data.
        """
        constraints = self._all_of("overlap", behavior, frame)
        if not constraints:
            return None
        kinds = _KINDS.items()
        found = [kind for kind, value in kinds if self._holds(constraints, None, frame, {"overlap": value})]
        if len(found) != 1:
            raise Undecided("constraints leave several kinds of `overlap`")
        return found[0]

    def _all_of(self, name: str, behavior: plan.Behavior, frame: Frame) -> list[TimeConstraint]:
        constraints = [each for each in self.constraints_on(behavior, frame, None) if name in each.names]
        if any(each.names != {name} or each.constraint.is_default for each in constraints):
            raise Undecided(f"constraints on `{name}` may be overridden, or also constrain other times")
        return constraints

    # -------------------------------------------------------- what meets constraints

    def _holds(
        self, constraints: list[TimeConstraint], it: Instance | None, frame: Frame, times: dict[str, Value]
    ) -> bool:
        shown = Holder((), times) if it is None else Holder(it.types, ChainMap(times, it.fields))
        seq = max(frame.start.seq, it.seq + 1) if it is not None else frame.start.seq
        for each in constraints:
            if not self.world.value(each.constraint.condition, each.environment.bind(it=shown), seq):
                return False
        return True

    def _values(self, constraints: list[TimeConstraint], it: Instance | None, frame: Frame) -> list[float]:
        """Return the times at which the truth of constraints may change [s]."""
        found = {0.0, -_FOREVER, _FOREVER}
        seq = max(frame.start.seq, it.seq + 1) if it is not None else frame.start.seq
        for each in constraints:
            environment = each.environment if it is None else each.environment.bind(it=it)
            for operand in [*_operands(each.constraint.condition)]:
                value = self.world.value(operand, environment, seq)
                bounds = [value.low, value.high] if isinstance(value, Range) else [value]
                numbers = (float(bound) for bound in bounds if isinstance(bound, int | float))
                found.update(number + beside for number in numbers for beside in (-_BESIDE, 0.0, _BESIDE))
        if len(found) > _MOST:
            raise Undecided("too many constraints on times")
        if constraints and constraints[0].names == {"duration"}:
            found = {value for value in found if value >= 0}
        return sorted(found)


def _operands(expression: plan.Expression) -> Iterator[plan.Expression]:
    """Yield the values that a condition compares with times.

    Raises:
        Undecided: It computes with times.
    """
    if not times_in(expression):
        return
    match expression:
        case plan.Logic(_, left, right):
            yield from _operands(left)
            yield from _operands(right)
        case plan.Not(operand):
            yield from _operands(operand)
        case plan.Compare(_, left, right) | plan.Contains(left, right) if all(
            _is_bare(each) or not times_in(each) for each in (left, right)
        ):
            yield from (each for each in (left, right) if not _is_bare(each))
        case _:
            raise Undecided("a constraint computes with times")


def _is_bare(expression: plan.Expression) -> bool:
    return is_time(expression) or (isinstance(expression, plan.Bound) and is_time(expression.range))
