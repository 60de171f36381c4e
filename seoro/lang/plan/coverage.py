"""Coverage items of the plan (7.5): what is sampled at which event, and into which buckets it is counted."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from typing import TypeAlias

from seoro.lang.frozen import Value
from seoro.lang.plan.events import OwnEvent
from seoro.lang.plan.expressions import Expression
from seoro.lang.plan.types import EnumValue
from seoro.lang.source import Span


class CoverageKind(Enum):
    """What an item is for: goals of a verification have a grade, records have none."""

    COVER = "cover"
    RECORD = "record"


class EachValue(Value):
    """A bucket for each value of a type that has few: booleans, enumerations, short ranges of whole numbers."""

    values: tuple[bool | int | EnumValue, ...]


class Edges(Value):
    """A bucket from each edge to the next, which belongs to the bucket above; the last one is closed."""

    edges: tuple[float, ...]  # ascending, in the item's unit


class Slices(Value):
    """Buckets of one width, from zero in both directions, as many as are needed."""

    width: float  # in the item's unit


class Levels(Value):
    """Buckets for the least and the greatest value, and three of one size between them: low, medium, high."""

    low: float  # in the item's unit
    high: float


class Distinct(Value):
    """A bucket for each value that occurs, of a type without end: strings."""


Buckets: TypeAlias = EachValue | Edges | Slices | Levels | Distinct


class CoverageUnit(Value):
    """A unit: `SI value = value * factor + offset`."""

    name: str
    factor: float
    offset: float


class CoverageItem(Value):
    """`cover` or `record` of a value.

    Args:
        name: Its name, unique in the type and what that inherits.
        owner: The type that declares it.
        kind: Which of the two.
        expression: The value, in the scope of the instance.
        it: The field for which `it` stands in the expression; None where it stands for the instance.
        unit: Of what is counted and recorded; None if the type is not physical.
        event: When it is sampled: an event of the type that declares it; in a struct or an actor, a phase is that
            of the scenario or action that holds the value; in a modifier, of what it modifies.
        buckets: How values are counted.
        ignore: Which values are left out; the binding of the item's name is the value, in SI units.
        illegal: Which values show a malfunction, likewise.
        target: How many samples a bucket needs.
        text: What it is about, for people.
        span: Where it is declared.
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
    """`cover` or `record` of the combinations of the values of other items, which have the same event (7.5.4).

    `items` are the names of those, none of which is a cross item itself; the rest is as for `CoverageItem`.
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
"""The items of types by the names of these; of scenarios and actions, by `behavior_type`; of modifiers, by
`modifier_type`. Inherited ones are with the base."""
