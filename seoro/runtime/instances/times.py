"""Constrained times of behaviors (7.3.13): timing parameters of compositions, and `duration` of invocations.

They are not fields. The run decides about times that constraints leave open, so a time gets a window of permitted
values instead of one value.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from math import inf
from typing import Final, NamedTuple

from seoro.lang import frozen
from seoro.lang.plan import (
    Binding,
    Constraint,
    Contains,
    EnumType,
    EnumValue,
    FieldDeclaration,
    Literal,
    Member,
    Overlap,
    PhysicalType,
    RangeOf,
    RangeType,
)
from seoro.lang.source import Span
from seoro.runtime.values.values import Range, Value

DURATION: Final = "duration"
OVERLAP: Final = "overlap"
START_TO_START: Final = "start_to_start"
END_TO_END: Final = "end_to_end"

FOREVER: Final = 1e9  # [s]; upper limit of all durations

ANY_TIME: Final = Range(0.0, inf)
_TIME: Final = PhysicalType("time", "s")
_KINDS: Final = EnumType("overlap_kind", tuple((kind.value, number) for number, kind in enumerate(Overlap)))
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
    overlap: Overlap | None = None
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

    def declarations(self) -> Iterable[tuple[FieldDeclaration, tuple[float, float] | None]]:
        """Yield the times as parameter declarations, with their limits [s]."""
        for name in self.names:
            type_ = RangeType(_TIME) if name == DURATION else _TIME
            yield FieldDeclaration(name, type_, None, False, self.span), _LIMITS[name]
        if self.overlap is not None:
            default = Literal(kind_value(self.overlap), self.span)
            yield FieldDeclaration(OVERLAP, _KINDS, default, False, self.span), None

    def constraints(self) -> Iterable[Constraint]:
        """Return the constraints from arguments; in them, `it` is the behavior."""
        for name, (bounds, span) in self.given.items():
            low, high = Literal(bounds.low, span), Literal(bounds.high, span)
            time = Member(Binding("it", span), name, span)
            yield Constraint(Contains(time, RangeOf(low, high, span), span), False, span)


def kind_value(kind: Overlap) -> EnumValue:
    """A kind of overlap as a value of scenarios."""
    return EnumValue(_KINDS.name, kind.value, dict(_KINDS.members)[kind.value])
