"""Coverage items of the plan (7.5): sampled values, their events, and their buckets."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from typing import Final, TypeAlias

from seoro.lang.frozen import Value
from seoro.lang.plan.events import OwnEvent
from seoro.lang.plan.expressions import Expression
from seoro.lang.plan.types import EnumValue
from seoro.lang.source import Span

UNIT_DIGITS: Final = 12  # significant digits of values in the unit of an item


class CoverageKind(Enum):
    """Purpose of an item: goals of a verification have a grade, records have none."""

    COVER = "cover"
    RECORD = "record"


class EachValue(Value):
    """A bucket per value, where there are few: booleans, enumerations, ranges of integers, listed values."""

    values: tuple[bool | int | float | str | EnumValue, ...]  # numbers in the item's unit


class Edges(Value):
    """A bucket from each edge to the next, which belongs to the bucket above; the last one is closed."""

    edges: tuple[float, ...]  # ascending, in the item's unit


class Slices(Value):
    """Buckets of equal width, from zero in both directions, as many as needed."""

    width: float  # in the item's unit


class Levels(Value):
    """Buckets for the minimum and the maximum, and three of equal size between them: low, medium, high."""

    low: float  # in the item's unit
    high: float


class Distinct(Value):
    """A bucket per occurring value, for types with unlimited values: strings."""


Buckets: TypeAlias = EachValue | Edges | Slices | Levels | Distinct


class CoverageUnit(Value):
    """A unit: `SI value = value * factor + offset`."""

    name: str
    factor: float
    offset: float

    def to_si(self, value: float) -> float:
        """Convert a value to SI."""
        return value * self.factor + self.offset

    def of_si(self, value: float) -> float:
        """Convert an SI value; rounded to `UNIT_DIGITS`, so that 50kph stays 50."""
        return float(f"{(value - self.offset) / self.factor:.{UNIT_DIGITS}g}")


class CoverageItem(Value):
    """`cover` or `record` of a value.

    Args:
        name: Its name, unique in the type and its bases.
        owner: The type that declares it.
        kind: `cover` or `record`.
        expression: The value, in the scope of the instance.
        it: The field that `it` denotes in the expression; None if `it` is the instance.
        unit: Unit of counted and recorded values; None if the type is not physical.
        event: The sampling event, of the declaring type. A phase in a struct or an actor is that of the scenario
            or action that holds the value; in a modifier, that of the modified behavior.
        buckets: Buckets of the values.
        ignore: Condition of ignored values; the binding of the item's name is the value, in SI units.
        illegal: Condition of values that indicate a malfunction, with the same binding.
        target: Number of samples that a bucket needs.
        text: Description for people.
        span: Its declaration.
    """

    name: str
    owner: str
    kind: CoverageKind
    expression: Expression
    it: str | None
    unit: CoverageUnit | None
    event: OwnEvent
    buckets: Buckets
    ignore: Expression | None
    illegal: Expression | None
    target: int
    text: str
    span: Span


class CrossItem(Value):
    """`cover` or `record` of combined values of other items with the same event (7.5.4).

    `items` are their names; none of them is a cross item. Other fields are as in `CoverageItem`.
    """

    name: str
    owner: str
    kind: CoverageKind
    items: tuple[str, ...]
    event: OwnEvent
    target: int
    text: str
    span: Span


AnyCoverageItem: TypeAlias = CoverageItem | CrossItem
Coverage: TypeAlias = Mapping[str, tuple[AnyCoverageItem, ...]]
"""Items by the name of the declaring type; of scenarios and actions, by `behavior_type`; of modifiers, by
`modifier_type`."""
