"""Buckets of coverage items (7.5.5, 7.5.7): their number, the bucket of a value, and the count of samples.

A boundary belongs to the bucket above it, and the last bucket is closed (7.5 is silent). `[10..130]` in
slices of 10 thus has twelve buckets, and 130 is in the last.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from dataclasses import field
from itertools import pairwise
from typing import assert_never

from seoro.deferred import dataclass
from seoro.lang.plan import (
    AnyCoverageItem,
    Buckets,
    CoverageItem,
    Distinct,
    EachValue,
    Edges,
    Levels,
    Plan,
    Slices,
)
from seoro.runtime.expressions.evaluation import evaluate
from seoro.runtime.instances.instances import Composed
from seoro.runtime.values.environment import Environment, EvaluationError
from seoro.runtime.values.values import Fields, Value, plain
from seoro.runtime.verdict import ItemCoverage

LEVELS = ("low", "medium", "high")


def number_of(buckets: Buckets) -> int | None:
    """Return the number of buckets; None if unbounded."""
    match buckets:
        case EachValue(values):
            return len(values)
        case Edges(edges):
            return len(edges) - 1
        case Levels():
            return len(LEVELS) + 2
        case Slices() | Distinct():
            return None
        case _:
            assert_never(buckets)


def labels_of(buckets: Buckets) -> tuple[str, ...] | None:
    """Return the names of all buckets, in order; None if unbounded."""
    match buckets:
        case EachValue(values):
            return tuple(map(label, values))
        case Edges(edges):
            return tuple(f"{low:.12g}..{high:.12g}" for low, high in pairwise(edges))
        case Levels():
            return ("min", *LEVELS, "max")
        case Slices() | Distinct():
            return None
        case _:
            assert_never(buckets)


def buckets_with(item: CoverageItem, plan: Plan) -> Buckets:
    """Return the buckets of an item, without single values that `ignore` or `illegal` exclude.

    A value for which these cannot be computed is not excluded.
    """
    if not isinstance(item.buckets, EachValue) or (item.ignore is None and item.illegal is None):
        return item.buckets
    return EachValue(tuple(value for value in item.buckets.values if not _is_excluded(item, value, plan)))


def _is_excluded(item: CoverageItem, value: Value, plan: Plan) -> bool:
    if item.unit is not None and isinstance(value, int | float):
        value = item.unit.to_si(value)
    constants = Environment(Composed("constants", Fields()), plan, {item.name: value})
    conditions = [each for each in (item.ignore, item.illegal) if each is not None]
    try:
        return any(bool(evaluate(each, constants)) for each in conditions)
    except EvaluationError:
        return False


def bucket_of(buckets: Buckets, value: Value) -> str | None:
    """Return the name of the bucket of a value; None outside all buckets."""
    match buckets:
        case EachValue(values):
            return next((label(each) for each in values if each == value), None)
        case Edges(edges):
            return _between(edges, _number(value))
        case Levels(low, high):
            return _level(low, high, _number(value))
        case Slices(width):
            return _slice(width, _number(value))
        case Distinct():
            return label(value)
        case _:
            assert_never(buckets)


def label(value: Value) -> str:
    """Return the bucket name of a value."""
    shown = plain(value)
    return str(shown).lower() if isinstance(shown, bool) else str(shown)


def _between(edges: tuple[float, ...], value: float) -> str | None:
    if not edges[0] <= value <= edges[-1]:
        return None
    first = bisect_left(edges, value)
    is_point = edges[first : first + 2] == (value, value)
    number = first if is_point else min(bisect_right(edges, value), len(edges) - 1) - 1
    return f"{edges[number]:.12g}..{edges[number + 1]:.12g}"


def _level(low: float, high: float, value: float) -> str | None:
    if not low <= value <= high:
        return None
    if value in (low, high):
        return "min" if value == low else "max"
    share = value / high if low == 0 else (value / 2 - low / 2) / (high / 2 - low / 2)  # halves avoid overflow
    return LEVELS[min(int(share * len(LEVELS)), len(LEVELS) - 1)]


def _slice(width: float, value: float) -> str | None:
    quotient = float(f"{value / width:.12g}")  # 0.3 / 0.1 is 3
    if math.isinf(quotient):
        return None
    low = math.floor(quotient) * width
    return f"{low:.12g}..{low + width:.12g}"


def _number(value: Value) -> float:
    assert isinstance(value, int | float), "checked: only numbers have boundaries"
    return value


@dataclass(eq=False)
class Tally:
    """Counts samples of an item, over all instances of its type.

    Args:
        item: The item.
        total: Number of buckets.
    """

    item: AnyCoverageItem
    total: int | None
    counts: dict[str, int] = field(default_factory=dict)
    outside: int = 0
    ignored: int = 0
    illegal: int = 0

    def count(self, bucket: str | None) -> None:
        """Count a sample; None for a value outside all buckets."""
        if bucket is None:
            self.outside += 1
        else:
            self.counts[bucket] = self.counts.get(bucket, 0) + 1

    def result(self) -> ItemCoverage:
        """Return the current result."""
        item = self.item
        unit = item.unit if isinstance(item, CoverageItem) else None
        return ItemCoverage(
            item=f"{item.owner}.{item.name}",
            kind=item.kind,
            event=item.event.name,
            unit=unit.name if unit is not None else "",
            text=item.text,
            target=item.target,
            buckets=tuple(self.counts.items()),
            total=self.total,
            outside=self.outside,
            ignored=self.ignored,
            illegal=self.illegal,
        )
