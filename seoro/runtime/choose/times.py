"""Times of behaviors that constraints bound (7.3.13): parameters of compositions, and `duration` of invocations.

They are no fields. What constraints leave open about a time is decided while the behavior runs, so a time gets all
that they leave, a window, and not one value.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from math import inf
from typing import Final, NamedTuple

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
from seoro.runtime.values import Range, Value

DURATION: Final = "duration"
OVERLAP: Final = "overlap"
START_TO_START: Final = "start_to_start"
END_TO_END: Final = "end_to_end"

FOREVER: Final = 1e9  # [s]; no behavior takes longer

ANY_TIME: Final = Range(0.0, inf)
_TIME: Final = PhysicalType("time", "s")
_KINDS: Final = EnumType("overlap_kind", tuple((kind.value, number) for number, kind in enumerate(Overlap)))
_LIMITS: Final = {
    DURATION: (0.0, FOREVER),
    START_TO_START: (-FOREVER, FOREVER),
    END_TO_END: (-FOREVER, FOREVER),
}


@dataclass(frozen=True)
class Window:
    """What is left of a time.

    Args:
        bounds: The least and the most that it may be [s]; of a duration, a range that it has to be in.
        span: What says so.
        text: The constraint because of which it may not be more; empty if that is an argument.
        value: One that fits [s].
        fits: Whether a time fits [s].
    """

    bounds: Range
    span: Span
    text: str = ""
    value: float = 0.0
    fits: Callable[[float], bool] = lambda _: True


class Times(NamedTuple):
    """The parameters of a behavior for its times.

    Args:
        span: The behavior.
        given: What arguments bound times to [s], with the places of these.
        overlap: How members overlap, of `parallel`, unless constraints say something else; None for all else.
        is_overlap_given: Whether an argument says so.
    """

    span: Span
    given: Mapping[str, tuple[Range, Span]]
    overlap: Overlap | None = None
    is_overlap_given: bool = False

    @property
    def names(self) -> tuple[str, ...]:
        """Their names, but for the kind of overlap."""
        return (DURATION,) if self.overlap is None else (START_TO_START, END_TO_END, DURATION)

    def plain(self) -> tuple[dict[str, Value], dict[str, Window]]:
        """Values and windows where no constraint is about them."""
        values: dict[str, Value] = {}
        for name in self.names:
            bounds = self.given[name][0] if name in self.given else ANY_TIME
            values[name] = bounds if name == DURATION else bounds.low
        if self.overlap is not None:
            values[OVERLAP] = kind_value(self.overlap)
        return values, {name: Window(bounds, span) for name, (bounds, span) in self.given.items()}

    def declarations(self) -> Iterable[tuple[FieldDeclaration, tuple[float, float] | None]]:
        """What they are as parameters of the behavior, and the limits of those that are times [s]."""
        for name in self.names:
            type_ = RangeType(_TIME) if name == DURATION else _TIME
            yield FieldDeclaration(name, type_, None, False, self.span), _LIMITS[name]
        if self.overlap is not None:
            default = Literal(kind_value(self.overlap), self.span)
            yield FieldDeclaration(OVERLAP, _KINDS, default, False, self.span), None

    def constraints(self) -> Iterable[Constraint]:
        """What arguments say; in them, `it` is the behavior."""
        for name, (bounds, span) in self.given.items():
            low, high = Literal(bounds.low, span), Literal(bounds.high, span)
            time = Member(Binding("it", span), name, span)
            yield Constraint(Contains(time, RangeOf(low, high, span), span), False, span)


def kind_value(kind: Overlap) -> EnumValue:
    """A kind of overlap as a value of scenarios."""
    return EnumValue(_KINDS.name, kind.value, dict(_KINDS.members)[kind.value])
