"""Counts of the buckets of `cover` items over the runs of campaigns."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import field
from itertools import pairwise
from typing import Any, Final, NamedTuple

from seoro.campaign.coverage.items import MOST_BUCKETS
from seoro.campaign.runs import End, Row
from seoro.campaign.store.batches import Batch
from seoro.campaign.store.covered import CoveredItem, Unreachable
from seoro.deferred import dataclass

MOST_ITEMS: Final = 1000


class EqualRuns(NamedTuple):
    """Runs with equal coverage.

    Args:
        passed: Number of passed runs.
        failed: Number of failed runs.
        first: Least number of a run.
    """

    passed: int
    failed: int
    first: int

    @property
    def total(self) -> int:
        """Number of the runs."""
        return self.passed + self.failed


@dataclass(eq=False)
class BucketCounts:
    """Counts of a bucket.

    Args:
        samples: Number of samples.
        passed: Number of runs with a sample that passed.
        failed: Number of runs with a sample that failed.
        first: Number of the first run with a sample; 0 without one.
    """

    samples: int = 0
    passed: int = 0
    failed: int = 0
    first: int = 0

    def add(self, samples: int, runs: EqualRuns) -> None:
        """Add the samples of runs.

        Args:
            samples: Samples of each run.
            runs: The runs.
        """
        self.samples += samples * runs.total
        self.passed += runs.passed
        self.failed += runs.failed
        self.first = min(self.first or runs.first, runs.first)

    @property
    def runs(self) -> int:
        """Number of runs with a sample."""
        return self.passed + self.failed


@dataclass(eq=False)
class ItemCounts:
    """Counts of an item.

    Args:
        item: Its qualified name.
        unit: Unit of its buckets.
        target: Samples that each bucket needs.
        listed: Names of all buckets; None if they are unbounded or unknown.
        total: Number of buckets; None if unbounded.
        buckets: Counts by bucket, without empty ones.
        unreachable: Buckets that constraints exclude, with the constraints.
        reached: Number of buckets with enough samples.
        illegal: Number of illegal values.
        outside: Number of values outside all buckets.
        is_cut: Whether it has more buckets than are counted.
    """

    item: str
    unit: str
    target: int
    listed: tuple[str, ...] | None
    total: int | None
    buckets: dict[str, BucketCounts] = field(default_factory=dict)
    unreachable: dict[str, tuple[str, ...]] = field(default_factory=dict)
    reached: int = 0
    illegal: int = 0
    outside: int = 0
    is_cut: bool = False

    def add(self, plain: Mapping[str, Any], runs: EqualRuns) -> None:
        """Add the samples of each of some runs, as in `coverage.json`."""
        for bucket, count in plain["buckets"].items():
            if bucket not in self.buckets:
                if len(self.buckets) >= MOST_BUCKETS:
                    self.is_cut = True
                    continue
                self.buckets[bucket] = BucketCounts()
            counts = self.buckets[bucket]
            before = counts.samples
            counts.add(count, runs)
            self.reached += before < self.needed <= counts.samples
        self.illegal += plain["illegal"] * runs.total
        self.outside += plain["outside"] * runs.total

    @property
    def needed(self) -> int:
        """Samples that a bucket needs, at least one."""
        return max(self.target, 1)

    @property
    def reachable(self) -> int | None:
        """Number of buckets that constraints allow; None if unbounded."""
        if self.total is None:
            return None
        return self.total - sum(bucket not in self.buckets for bucket in self.unreachable)

    @property
    def excluded(self) -> Mapping[tuple[str, ...], list[str]]:
        """Unreachable buckets by the constraints that exclude them."""
        found: dict[tuple[str, ...], list[str]] = {}
        for bucket, reasons in self.unreachable.items():
            if bucket not in self.buckets:
                found.setdefault(reasons, []).append(bucket)
        return found

    @property
    def holes(self) -> list[str]:
        """Reachable buckets without enough samples, as far as they are known; `LOW..HIGH` if they are ranges."""
        if self.listed is not None:
            known = (bucket for bucket in self.listed if bucket not in self.unreachable or bucket in self.buckets)
            return [bucket for bucket in known if self._samples(bucket) < self.needed]
        try:
            ranges = sorted(_range(bucket) for bucket in self.buckets)
        except ValueError:
            return []
        return [f"{before[1]:.12g}..{after[0]:.12g}" for before, after in pairwise(ranges) if before[1] < after[0]]

    def _samples(self, bucket: str) -> int:
        return self.buckets[bucket].samples if bucket in self.buckets else 0


def failing(item: ItemCounts) -> list[tuple[str, BucketCounts]]:
    """Return the buckets of an item with failed runs, those with the largest share of failures first."""
    failed = [(bucket, counts) for bucket, counts in item.buckets.items() if counts.failed]
    return sorted(failed, key=lambda each: (-each[1].failed / each[1].runs, -each[1].failed))


class MergedCoverage:
    """Coverage of `cover` items over runs.

    Args:
        items: Definitions of items that the runs may have; others are taken from the runs.
        unreachable: Buckets that constraints exclude.
    """

    def __init__(self, items: Iterable[CoveredItem] = (), unreachable: Iterable[Unreachable] = ()) -> None:
        self.items: dict[str, ItemCounts] = {
            each.item: ItemCounts(
                each.item,
                each.unit,
                each.target,
                each.buckets,
                len(each.buckets) if each.buckets is not None else None,
            )
            for each in items
        }
        self.exclude(unreachable)

    def exclude(self, unreachable: Iterable[Unreachable]) -> None:
        """Leave out buckets that constraints exclude."""
        for each in unreachable:
            counts = self.items.get(each.item)
            if counts is not None:
                counts.unreachable[each.bucket] = each.reasons

    def add(self, row: Row) -> None:
        """Add the coverage of a run that passed or failed."""
        has_passed = row.status is End.PASSED
        self.add_equal(row.coverage, EqualRuns(has_passed, not has_passed, row.run))

    def add_equal(self, coverage: Iterable[Mapping[str, Any]], runs: EqualRuns) -> None:
        """Add the coverage of each of some runs.

        Args:
            coverage: Coverage of each, as in `coverage.json`.
            runs: The runs, which passed or failed.
        """
        for plain in coverage:
            if plain["kind"] != "cover":
                continue
            counts = self.items.get(plain["item"])
            if counts is None:
                if len(self.items) >= MOST_ITEMS:
                    continue
                counts = self.items[plain["item"]] = ItemCounts(
                    plain["item"], plain["unit"], plain["target"], None, plain["total"]
                )
            elif counts.total is None:
                counts.total = plain["total"]
            counts.add(plain, runs)

    def add_batch(self, batch: Batch) -> None:
        """Add the coverage of the runs of a batch that passed or failed.

        Raises:
            UsageError: A row is invalid.
        """
        runs = batch.column("run")
        passed, failed = batch.ends.get(End.PASSED, ()), batch.ends.get(End.FAILED, ())
        have_passed = set(passed)
        for coverage, positions in batch.coverage([*passed, *failed]):
            count = sum(map(have_passed.__contains__, positions))
            first = min(map(runs.__getitem__, positions))
            self.add_equal(coverage, EqualRuns(count, len(positions) - count, first))

    @property
    def share(self) -> float:
        """Share of the reachable buckets of all items that have enough samples; 0 without a bounded item."""
        bounded = [each for each in self.items.values() if each.reachable]
        reachable = sum(each.reachable or 0 for each in bounded)
        return sum(each.reached for each in bounded) / reachable if reachable else 0.0

    def lacking(self) -> Iterator[tuple[str, str]]:
        """Yield the known buckets without a sample, with their items."""
        for counts in self.items.values():
            for bucket in counts.listed or ():
                if bucket not in counts.buckets:
                    yield counts.item, bucket


def _range(bucket: str) -> tuple[float, float]:
    low, _, high = bucket.partition("..")
    return float(low), float(high)
