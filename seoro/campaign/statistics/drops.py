"""Drop of the pass rate from one campaign to another: upper bounds, and a test for independent runs."""

from __future__ import annotations

import math
from statistics import NormalDist
from typing import Final, TypeAlias

from seoro.campaign.statistics.beta import log_choose
from seoro.campaign.statistics.rates import CONFIDENCE

Passed: TypeAlias = tuple[int, int]
"""Number of runs that passed, and of all runs with a verdict."""

_STEPS: Final = 50  # bisections
_EQUAL: Final = 1e-7  # relative, of probabilities


def paired_drop_bound(failing: int, passing: int, pairs: int, confidence: float = CONFIDENCE) -> float:
    """Return an upper bound for the drop of the pass rate, from pairs of runs.

    It is the largest drop that the score test of Tango accepts. See Tango, "Equivalence test and confidence
    interval for the difference in proportions for the paired-sample design", Statistics in Medicine 17, 1998.

    Args:
        failing: Number of pairs that passed before and fail now.
        passing: Number of pairs that failed before and pass now.
        pairs: Number of all pairs, at least one.
        confidence: Approximate probability that the drop is smaller.
    """
    limit = NormalDist().inv_cdf(confidence)
    low, high = (failing - passing) / pairs, 1.0
    for _ in range(_STEPS):
        middle = (low + high) / 2.0
        if _score(failing, passing, pairs, middle) < limit:
            low = middle
        else:
            high = middle
    return high


def _score(failing: int, passing: int, pairs: int, drop: float) -> float:
    """Return the statistic of the test of a drop: standard deviations by which the observed one is smaller."""
    excess = pairs * drop - failing + passing
    b = (2 * pairs + failing - passing) * -drop - failing - passing
    c = failing * drop * (1.0 + drop)
    share = (math.sqrt(max(b * b - 8 * pairs * c, 0.0)) - b) / (4 * pairs)  # most likely share of failing pairs
    variance = pairs * (2.0 * share - drop * (1.0 + drop))
    if variance <= 0.0:
        return math.inf if excess > 0.0 else 0.0
    return excess / math.sqrt(variance)


def unpaired_drop_bound(before: Passed, after: Passed, confidence: float = CONFIDENCE) -> float:
    """Return an upper bound for the drop of the pass rate, from independent runs.

    It joins the intervals of Wilson for both rates (Newcombe, "Interval estimation for the difference between
    independent proportions", method 10, Statistics in Medicine 17, 1998).

    Args:
        before, after: The counts, with at least one run each.
        confidence: Approximate probability that the drop is smaller.
    """
    z = NormalDist().inv_cdf(confidence)
    first, second = before[0] / before[1], after[0] / after[1]
    above = _wilson(*before, z) - first
    below = second - _wilson(*after, -z)
    return first - second + math.hypot(above, below)


def _wilson(passed: int, runs: int, z: float) -> float:
    """Return the bound of a rate that is `z` standard deviations from the observed one."""
    rate = passed / runs
    centre = rate + z * z / (2 * runs)
    return (centre + z * math.sqrt(rate * (1.0 - rate) / runs + (z / (2 * runs)) ** 2)) / (1.0 + z * z / runs)


def fisher(before: Passed, after: Passed) -> float:
    """Return the p-value of the exact, two-sided test of Fisher (1935) for equal rates of independent runs.

    Args:
        before, after: The counts.
    """
    runs, total = before[1], before[1] + after[1]
    passed = before[0] + after[0]
    logs = {
        count: log_choose(passed, count) + log_choose(total - passed, runs - count) - log_choose(total, runs)
        for count in range(max(0, runs - (total - passed)), min(runs, passed) + 1)
    }
    limit = logs[before[0]] + _EQUAL
    return min(1.0, sum(math.exp(each) for each in logs.values() if each <= limit))
