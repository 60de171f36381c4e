"""Sequential test of a rate: as many runs as a decision needs."""

from __future__ import annotations

import math
from enum import Enum
from typing import Final

from seoro.lang.frozen import Value

ERRORS: Final = 0.05


class Decision(Enum):
    """Decisions of a test."""

    GOOD = "good"  # the rate is at least the good one
    BAD = "bad"  # the rate is at most the bad one
    OPEN = "open"


class SequentialTest(Value):
    """Sequential probability ratio test of Wald ("Sequential Tests of Statistical Hypotheses", 1945).

    Between the two rates, either decision is right, and the test takes longest.

    Args:
        good: Rate that shall be accepted.
        bad: Lower rate that shall be rejected.
        errors: Probability of a wrong decision, of either kind.
    """

    good: float
    bad: float
    errors: float = ERRORS

    def ratio(self, successes: int, failures: int) -> float:
        """Return the logarithm of the ratio of the likelihoods of the good and of the bad rate."""
        return successes * math.log(self.good / self.bad) + failures * math.log((1 - self.good) / (1 - self.bad))

    def decide(self, successes: int, failures: int) -> Decision:
        """Decide after a number of runs. The first decision holds; more runs do not change it.

        Args:
            successes, failures: Number of runs so far, each independent of those before it.
        """
        limit = math.log((1.0 - self.errors) / self.errors)
        ratio = self.ratio(successes, failures)
        if ratio >= limit:
            return Decision.GOOD
        return Decision.BAD if ratio <= -limit else Decision.OPEN
