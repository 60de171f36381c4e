"""Pass rate of a campaign, with its interval."""

from __future__ import annotations

from enum import Enum

from seoro.campaign.statistics.rates import Bounds, fixed_bounds, live_bounds
from seoro.campaign.stopping.rules import number_of_percent, percent
from seoro.lang.frozen import Value


class Validity(Enum):
    """Validity of an interval of the pass rate."""

    NONE = "not a probability"  # the strategy chose or repeated values: no interval
    ALWAYS = "valid at any time"
    FIXED = "95 % confidence"  # for a number of runs that was fixed in advance


class Rate(Value):
    """Pass rate of runs with a verdict.

    Args:
        passed: Number of runs that passed.
        failed: Number of runs that failed.
        validity: Validity of its interval.
    """

    passed: int
    failed: int
    validity: Validity

    @property
    def runs(self) -> int:
        """Number of runs with a verdict."""
        return self.passed + self.failed

    @property
    def share(self) -> float | None:
        """Share of passed runs, from 0 to 1; None without a run."""
        return self.passed / self.runs if self.runs else None

    @property
    def bounds(self) -> Bounds | None:
        """95 % interval of the probability to pass; None unless the runs are a random sample."""
        match self.validity:
            case Validity.NONE:
                return None
            case Validity.ALWAYS:
                return live_bounds(self.passed, self.runs)
            case Validity.FIXED:
                return fixed_bounds(self.passed, self.runs)

    def __str__(self) -> str:
        if self.share is None:
            return "pass rate unknown: no run has a verdict"
        if (bounds := self.bounds) is None:
            return f"pass rate {percent(self.share)} of {self.runs:,} runs"
        interval = f"{number_of_percent(bounds.low)} to {percent(bounds.high)}"
        return f"pass rate {percent(self.share)} ({interval}, {self.validity.value})"

    def _repr_html_(self) -> str:
        """Return the rate for notebooks."""
        return f"<p><b>{self}</b> ({self.passed:,} passed, {self.failed:,} failed)</p>"
