"""Values that failures with the same reason have in common, apart from a few outliers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Final

from seoro.campaign.report.columns import Column, is_number
from seoro.campaign.report.grouping import Bucket
from seoro.lang.frozen import Value

NEARLY_ALL: Final = 0.95  # of the failures
_BINS: Final = 100  # of a parameter in a group of failures, of which there are many


class Common(Value):
    """Values in common.

    Args:
        low: Least of them; of texts, the only one.
        high: Largest of them; of texts, the only one.
        count: Number of failures with one of them.
    """

    low: Any
    high: Any
    count: int

    @property
    def width(self) -> float:
        """Difference of both numbers; 0 for texts."""
        return float(self.high - self.low) if is_number(self.low) else 0.0


class CommonValues:
    """Values of a parameter in failures with the same reason."""

    def __init__(self) -> None:
        self._column = Column(_BINS)
        self._ends: tuple[float, float] | None = None  # least and largest number
        self._count = 0

    def add(self, values: Sequence[object]) -> None:
        """Count values of failures; None without one."""
        self._count += len(values)
        self._column.add_equal(values, has_failed=True)
        numbers = [value for value in values if is_number(value)]
        if numbers:
            self._ends = min(*numbers, *(self._ends or numbers)), max(*numbers, *(self._ends or numbers))

    def narrower_than(self, others: Column) -> Common | None:
        """Return the values of most failures, if these are nearly all, and the values few of those of all runs.

        Args:
            others: The values of all runs.
        """
        found = max(self._ranges(others), key=lambda each: (each.count, -each.width), default=None)
        return found if found is not None and found.count >= NEARLY_ALL * self._count else None

    def _ranges(self, others: Column) -> Iterator[Common]:
        """Yield the largest range up to each value that is narrower than the range of others, and single texts."""
        buckets = [bucket for bucket in self._column.grouping(_BINS).buckets if bucket.runs]
        first = 0
        for last, bucket in enumerate(buckets):
            if bucket.low is None and not is_number(bucket.exact):  # a text, or a rest
                first = last + 1
                if bucket.exact is not None and others.is_narrower(bucket.exact, bucket.exact):
                    yield Common(bucket.exact, bucket.exact, bucket.runs)
                continue
            while first <= last:
                found = self._range(buckets[first : last + 1])
                if others.is_narrower(found.low, found.high):
                    yield found
                    break
                first += 1

    def _range(self, buckets: Sequence[Bucket]) -> Common:
        low, high = buckets[0].low, buckets[-1].high
        count = sum(bucket.runs for bucket in buckets)
        if low is None or high is None or self._ends is None:
            return Common(buckets[0].exact, buckets[-1].exact, count)
        return Common(max(low, self._ends[0]), min(high, self._ends[1]), count)
