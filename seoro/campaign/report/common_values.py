"""Values that failures with the same reason have in common, apart from a few outliers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import accumulate
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
        """Return the values of nearly all failures, if they are few of those of all runs.

        An outlier is left out if that makes the range narrower by more than its share of the failures.

        Args:
            others: The values of all runs.
        """
        extent = others.extent
        found = (each for each in self._ranges() if others.is_narrower(each.low, each.high))

        def gain(each: Common) -> float:
            return each.count / self._count - (each.width / extent if each.width else 0.0)

        return max(found, key=gain, default=None)

    def _ranges(self) -> Iterator[Common]:
        """Yield the ranges and texts with nearly all failures, the widest first."""
        needed = NEARLY_ALL * self._count
        buckets = [bucket for bucket in self._column.grouping(_BINS).buckets if bucket.runs]
        numbers = [bucket for bucket in buckets if bucket.low is not None or is_number(bucket.exact)]
        sums = list(accumulate((bucket.runs for bucket in numbers), initial=0))
        for first in range(len(numbers)):
            for last in range(len(numbers), first, -1):
                if (count := sums[last] - sums[first]) < needed:
                    break
                yield self._range(numbers[first], numbers[last - 1], count)
        for bucket in buckets:
            if isinstance(bucket.exact, str) and bucket.runs >= needed:
                yield Common(bucket.exact, bucket.exact, bucket.runs)

    def _range(self, first: Bucket, last: Bucket, count: int) -> Common:
        if first.low is None or last.high is None or self._ends is None:
            return Common(first.exact, last.exact, count)
        return Common(max(first.low, self._ends[0]), min(last.high, self._ends[1]), count)
