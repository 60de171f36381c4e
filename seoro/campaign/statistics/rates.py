"""Bounds of a rate, such as that of passed runs: for a fixed number of runs, and at any time."""

from __future__ import annotations

import math
from typing import Final

from seoro.campaign.statistics.beta import beta_quantile, log_beta
from seoro.lang.frozen import Value

CONFIDENCE: Final = 0.95
_STEPS: Final = 40  # bisections of a bracket little wider than the interval


class Bounds(Value):
    """Interval for an unknown number.

    Args:
        low: Lower bound.
        high: Upper bound.
    """

    low: float
    high: float


def fixed_bounds(successes: int, runs: int, confidence: float = CONFIDENCE) -> Bounds:
    """Return the exact interval of Clopper and Pearson (1934) for a number of runs that was fixed in advance.

    An interval that is computed again after each run, until it looks good, excludes the truth far more often than
    it promises. `live_bounds` does not.

    Args:
        successes: Number of successes.
        runs: Number of runs, independent of each other.
        confidence: Minimum probability that the interval contains the rate.

    Raises:
        ValueError: The numbers are not those of a rate.
    """
    _check(successes, runs, confidence)
    error = (1.0 - confidence) / 2.0
    failures = runs - successes
    return Bounds(
        beta_quantile(error, successes, failures + 1) if successes else 0.0,
        beta_quantile(1.0 - error, successes + 1, failures) if failures else 1.0,
    )


def live_bounds(successes: int, runs: int, confidence: float = CONFIDENCE) -> Bounds:
    """Return the interval of a confidence sequence, which is valid at any time.

    With probability `confidence`, the intervals after 1, 2, 3, ... runs all contain the rate. So a campaign may
    stop because of them.

    Under a rate, the likelihood ratio of a uniform mixture of all rates to it is a martingale (Robbins,
    "Statistical methods related to the law of the iterated logarithm", 1970). By the inequality of Ville, it ever
    reaches 1 / error with at most the probability `error`. Howard et al., "Time-uniform, nonparametric,
    nonasymptotic confidence sequences", Annals of Statistics 49 (2021), compare it with others.

    Args:
        successes: Number of successes.
        runs: Number of runs, each independent of those before it; without runs, nothing is known.
        confidence: Minimum probability that all intervals contain the rate.

    Raises:
        ValueError: The numbers are not those of a rate.
    """
    _check(successes, runs, confidence)
    if not runs:
        return Bounds(0.0, 1.0)
    failures = runs - successes
    least = log_beta(successes + 1, failures + 1) + math.log(1.0 - confidence)
    return Bounds(_lower(successes, failures, least), 1.0 - _lower(failures, successes, least))


def _lower(successes: int, failures: int, least: float) -> float:
    """Return the smallest rate at which the logarithm of the likelihood is at least `least`."""
    if not successes:
        return 0.0
    runs = successes + failures
    best = successes / runs
    # By Pinsker's inequality, it falls by at least 2 runs (rate - best)^2.
    excess = max(_log_likelihood(successes, failures, best) - least, 0.0)
    low, high = max(best - math.sqrt(excess / (2.0 * runs)), 0.0), best
    for _ in range(_STEPS):
        middle = (low + high) / 2.0
        if _log_likelihood(successes, failures, middle) < least:
            low = middle
        else:
            high = middle
    return low


def _log_likelihood(successes: int, failures: int, rate: float) -> float:
    of_failures = failures * math.log1p(-rate) if failures else 0.0
    return (successes * math.log(rate) if successes else 0.0) + of_failures


def _check(successes: int, runs: int, confidence: float) -> None:
    if not 0 <= successes <= runs:
        raise ValueError(f"expected 0 to {runs} successes, found {successes}")
    if not 0.0 < confidence < 1.0:
        raise ValueError(f"expected a confidence between 0 and 1, found {confidence}")
