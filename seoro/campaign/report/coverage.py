"""Coverage of the items of a scenario over all runs of a campaign."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import field
from itertools import pairwise
from typing import Any, Final

from seoro.lang.lazy_dataclass import lazy_dataclass

MOST_BUCKETS: Final = 1000  # that are counted, of an item


@lazy_dataclass
class ItemCounts:
    """Samples of an item by bucket.

    Args:
        item: Its name.
        unit: Unit of its buckets.
        target: Samples that each bucket needs.
        total: Number of buckets; None if unbounded.
        hits: Samples by bucket.
        illegal: Number of illegal values.
        outside: Number of values outside all buckets.
        is_cut: Whether it has more buckets than are counted.
    """

    item: str
    unit: str
    target: int
    total: int | None
    hits: Counter[str] = field(default_factory=Counter)
    illegal: int = 0
    outside: int = 0
    is_cut: bool = False

    def add(self, plain: Mapping[str, Any]) -> None:
        """Add the samples of a run, as in `coverage.json`."""
        for bucket, count in plain["buckets"].items():
            if bucket in self.hits or len(self.hits) < MOST_BUCKETS:
                self.hits[bucket] += count
            else:
                self.is_cut = True
        self.illegal += plain["illegal"]
        self.outside += plain["outside"]

    @property
    def reached(self) -> int:
        """Number of buckets with enough samples."""
        return sum(count >= max(self.target, 1) for count in self.hits.values())

    @property
    def gaps(self) -> list[str]:
        """Ranges without a sample between others, if the buckets are ranges `LOW..HIGH`."""
        try:
            ranges = sorted(_range(bucket) for bucket in self.hits)
        except ValueError:
            return []
        return [f"{before[1]:.12g}..{after[0]:.12g}" for before, after in pairwise(ranges) if before[1] < after[0]]


class MergedCoverage:
    """Coverage of `cover` items; those whose definitions differ are counted apart."""

    def __init__(self) -> None:
        self.items: dict[tuple[object, ...], ItemCounts] = {}

    def add(self, coverage: tuple[Mapping[str, Any], ...]) -> None:
        """Add the coverage of a run."""
        for plain in coverage:
            if plain["kind"] != "cover":
                continue
            key = (plain["item"], plain["unit"], plain["target"], plain["total"])
            counts = self.items.get(key)
            if counts is None:
                counts = self.items[key] = ItemCounts(*key)
            counts.add(plain)


def _range(bucket: str) -> tuple[float, float]:
    low, _, high = bucket.partition("..")
    return float(low), float(high)
