"""Rules that end a campaign by the verdicts of its runs."""

from __future__ import annotations

from typing import Protocol

from seoro.campaign.statistics.rates import live_bounds
from seoro.campaign.statistics.sequential_test import Decision, SequentialTest
from seoro.lang.frozen import Value


class Stop(Value):
    """End of a campaign by a rule.

    Args:
        reason: Reason, for people.
        decision: Decision about the rate, for rules that decide.
    """

    reason: str
    decision: Decision = Decision.OPEN


class Rule(Protocol):
    """Rule that ends a campaign."""

    @property
    def needs_samples(self) -> bool:
        """Whether the rule is valid for independent runs only."""

    def check(self, passed: int, failed: int, coverage: float = 0.0) -> Stop | None:
        """Return the end of the campaign, or None to continue.

        Args:
            passed, failed: Number of runs with these verdicts.
            coverage: Share of the reachable buckets of `cover` items that have enough samples.
        """


class Accuracy(Value):
    """Ends a campaign when the rate of passed runs is known well enough.

    Args:
        half_width: Half the width of the interval.
    """

    half_width: float
    needs_samples = True

    def check(self, passed: int, failed: int, coverage: float = 0.0) -> Stop | None:
        """See `Rule`."""
        bounds = live_bounds(passed, passed + failed)
        if (bounds.high - bounds.low) / 2.0 > self.half_width:
            return None
        return Stop(f"the pass rate is known to +- {percent(self.half_width)}")


class RateTest(Value):
    """Ends a campaign when a test has decided about the rate of passed runs.

    Args:
        test: The test.
    """

    test: SequentialTest
    needs_samples = True

    def check(self, passed: int, failed: int, coverage: float = 0.0) -> Stop | None:
        """See `Rule`."""
        decision = self.test.decide(passed, failed)
        if decision is Decision.OPEN:
            return None
        good, bad = percent(self.test.good), percent(self.test.bad)
        found, other = (good, bad) if decision is Decision.GOOD else (bad, good)
        return Stop(f"the pass rate is {found} rather than {other}", decision)


class RateBound(Value):
    """Ends a campaign when the interval of the rate of passed runs excludes a rate.

    Args:
        rate: The rate.
    """

    rate: float
    needs_samples = True

    def check(self, passed: int, failed: int, coverage: float = 0.0) -> Stop | None:
        """See `Rule`."""
        bounds = live_bounds(passed, passed + failed)
        if bounds.low >= self.rate:
            return Stop(f"the pass rate is at least {percent(self.rate)}", Decision.GOOD)
        if bounds.high < self.rate:
            return Stop(f"the pass rate is less than {percent(self.rate)}", Decision.BAD)
        return None


class Failures(Value):
    """Ends a campaign after a number of failures.

    Args:
        count: The number.
    """

    count: int
    needs_samples = False

    def check(self, passed: int, failed: int, coverage: float = 0.0) -> Stop | None:
        """See `Rule`."""
        if failed < self.count:
            return None
        return Stop("first failure" if self.count == 1 else f"{self.count} failures")


class CoverageGoal(Value):
    """Ends a campaign when enough buckets of `cover` items have enough samples.

    Args:
        share: Share of the reachable buckets.
    """

    share: float
    needs_samples = False

    def check(self, passed: int, failed: int, coverage: float = 0.0) -> Stop | None:
        """See `Rule`."""
        return Stop(f"the coverage is {percent(coverage)}") if coverage >= self.share else None


def percent(share: float) -> str:
    """Format a share as percentage, see `number_of_percent`."""
    return f"{number_of_percent(share)} %"


def number_of_percent(share: float) -> str:
    """Format a share in percent, without the sign: two decimals, or more if it would be rounded to 0 or 100."""
    texts = (f"{100.0 * share:.{digits}f}" for digits in range(2, 13))
    text = next((text for text in texts if float(text) not in (0.0, 100.0)), f"{100.0 * share:.2f}")
    return text.rstrip("0").rstrip(".")
