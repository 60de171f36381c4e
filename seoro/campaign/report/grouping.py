"""Groups of the values of a column, with the runs that passed and failed in each."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from seoro.lang.frozen import Value


class Bucket(Value):
    """One group of values.

    Args:
        label: Its values, for people.
        passed: Number of runs that passed.
        failed: Number of runs that failed.
        low: Lower end, which belongs to it; None unless it is a range.
        high: Upper end, which does not.
        exact: Its only value, unless it is a range or all other values.
    """

    label: str
    passed: int
    failed: int
    low: float | None = None
    high: float | None = None
    exact: Any = None

    @property
    def runs(self) -> int:
        """Number of runs."""
        return self.passed + self.failed


class Grouping(Value):
    """Groups of a column, in order.

    Args:
        buckets: The groups.
    """

    buckets: tuple[Bucket, ...]

    @property
    def is_of_ranges(self) -> bool:
        """Whether the groups are ranges of numbers, without gaps."""
        return bool(self.buckets) and self.buckets[0].low is not None

    def index_of(self, value: object) -> int | None:
        """Return the number of the group of a value, from 0; None if it is in none."""
        for number, bucket in enumerate(self.buckets):
            if bucket.low is None or bucket.high is None:
                if bucket.exact == value or bucket.exact is None:
                    return number
            elif isinstance(value, int | float) and bucket.low <= value < bucket.high:
                return number
        return None


def influence(buckets: Sequence[Bucket]) -> float:
    """Return how much more pass rates of groups differ than by chance, in standard deviations.

    It is Pearson's chi-squared for equal rates, less its mean, over its standard deviation
    (`k - 1` and `sqrt(2 (k - 1))` for `k` groups).
    """
    used = [bucket for bucket in buckets if bucket.runs]
    runs, failed = sum(each.runs for each in used), sum(each.failed for each in used)
    freedom = len(used) - 1
    if freedom < 1 or failed in (0, runs):
        return 0.0
    share = failed / runs
    squares = sum((each.failed - share * each.runs) ** 2 / each.runs for each in used)
    return float((squares / (share * (1.0 - share)) - freedom) / (2.0 * freedom) ** 0.5)
