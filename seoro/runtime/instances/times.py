"""Constrained times of behaviors (7.3.13): timing parameters of compositions, and `duration` of invocations.

They are not fields. The run decides about times that constraints leave open, so a time gets a window of permitted
values instead of one value.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from math import inf
from typing import Final, NamedTuple

from seoro.lang import frozen, plan
from seoro.lang.source import Span
from seoro.runtime.values.values import Range, Value

DURATION: Final = "duration"
OVERLAP: Final = "overlap"
START_TO_START: Final = "start_to_start"
END_TO_END: Final = "end_to_end"

FOREVER: Final = 1e9  # [s]; upper limit of all durations

ANY_TIME: Final = Range(0.0, inf)
_TIME: Final = plan.PhysicalType("time", "s")
_KINDS: Final = plan.EnumType(
    "overlap_kind", tuple((kind.value, number) for number, kind in enumerate(plan.Overlap))
)
_LIMITS: Final = {
    DURATION: (0.0, FOREVER),
    START_TO_START: (-FOREVER, FOREVER),
    END_TO_END: (-FOREVER, FOREVER),
}


class Window(frozen.Value):
    """Permitted values of a time.

    Args:
        bounds: Minimum and maximum [s]; for a duration, the range that contains it.
        span: Text that determines it.
        text: Constraint that determines the maximum; empty for an argument.
        value: A permitted value [s].
        fits: Whether a value is permitted [s].
    """

    bounds: Range
    span: Span
    text: str = ""
    value: float = 0.0
    fits: Callable[[float], bool] = lambda _: True


class Times(NamedTuple):
    """Timing parameters of a behavior.

    Args:
        span: The behavior.
        given: Bounds from arguments [s], with their places.
        overlap: Overlap of the members of `parallel`, unless constraints change it; None for other behaviors.
        is_overlap_given: Whether an argument gives it.
    """

    span: Span
    given: Mapping[str, tuple[Range, Span]]
    overlap: plan.Overlap | None = None
    is_overlap_given: bool = False

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the times, without the kind of overlap."""
        return (DURATION,) if self.overlap is None else (START_TO_START, END_TO_END, DURATION)

    def plain(self) -> tuple[dict[str, Value], dict[str, Window]]:
        """Return values and windows for behaviors without constraints on times."""
        values: dict[str, Value] = {}
        for name in self.names:
            bounds = self.given[name][0] if name in self.given else ANY_TIME
            values[name] = bounds if name == DURATION else bounds.low
        if self.overlap is not None:
            values[OVERLAP] = kind_value(self.overlap)
        return values, {name: Window(bounds, span) for name, (bounds, span) in self.given.items()}

    def declarations(self) -> Iterable[tuple[plan.FieldDeclaration, tuple[float, float] | None]]:
        """Yield the times as parameter declarations, with their limits [s]."""
        for name in self.names:
            type_ = plan.RangeType(_TIME) if name == DURATION else _TIME
            yield plan.FieldDeclaration(name, type_, None, False, self.span), _LIMITS[name]
        if self.overlap is not None:
            default = plan.Literal(kind_value(self.overlap), self.span)
            yield plan.FieldDeclaration(OVERLAP, _KINDS, default, False, self.span), None

    def constraints(self) -> Iterable[plan.Constraint]:
        """Return the constraints from arguments; in them, `it` is the behavior."""
        for name, (bounds, span) in self.given.items():
            low, high = plan.Literal(bounds.low, span), plan.Literal(bounds.high, span)
            time = plan.Member(plan.Binding("it", span), name, span)
            yield plan.Constraint(plan.Contains(time, plan.RangeOf(low, high, span), span), False, span)


def kind_value(kind: plan.Overlap) -> plan.EnumValue:
    """A kind of overlap as a value of scenarios."""
    return plan.EnumValue(_KINDS.name, kind.value, dict(_KINDS.members)[kind.value])
