"""Paired comparison of two campaigns: the same variants and seeds, another version."""

from __future__ import annotations

import math
from collections.abc import Sequence
from random import Random
from statistics import median
from typing import Final

from seoro.campaign.statistics.rates import CONFIDENCE, Bounds

RESAMPLES: Final = 2000


def mcnemar(newly_failing: int, newly_passing: int) -> float:
    """Return the p-value of the exact, two-sided test of McNemar (1947).

    Pairs with equal verdicts do not count. Without a difference between the campaigns, each of the others is newly
    failing or newly passing with equal probability.

    Args:
        newly_failing: Number of pairs that passed before and fail now.
        newly_passing: Number of pairs that failed before and pass now.
    """
    changed = newly_failing + newly_passing
    fewer = min(newly_failing, newly_passing)
    tail = sum(math.exp(_log_choose(changed, count) - changed * math.log(2.0)) for count in range(fewer + 1))
    return min(1.0, 2.0 * tail)


def _log_choose(total: int, chosen: int) -> float:
    return math.lgamma(total + 1) - math.lgamma(chosen + 1) - math.lgamma(total - chosen + 1)


def adjust(p_values: Sequence[float]) -> tuple[float, ...]:
    """Return p-values adjusted for several tests, by the method of Holm (1979).

    If those of at most `error` are called significant, any of them is wrong with at most the probability `error`.

    Args:
        p_values: P-values, in any order, which the result has too.
    """
    adjusted = [0.0] * len(p_values)
    largest = 0.0
    for rank, index in enumerate(sorted(range(len(p_values)), key=p_values.__getitem__)):
        largest = max(largest, min(1.0, (len(p_values) - rank) * p_values[index]))
        adjusted[index] = largest
    return tuple(adjusted)


def median_change(changes: Sequence[float], seed: int, confidence: float = CONFIDENCE) -> Bounds:
    """Return an interval for the median change between paired measurements, by the percentile bootstrap.

    See Efron and Tibshirani, "An Introduction to the Bootstrap", 1993, chapter 13.

    Args:
        changes: Change of each pair, at least one.
        seed: Seed of the resamples.
        confidence: Approximate probability that the interval contains the median.
    """
    random = Random(seed)  # noqa: S311 - not for secrets
    medians = sorted(median(random.choices(changes, k=len(changes))) for _ in range(RESAMPLES))
    outside = round((1.0 - confidence) / 2.0 * RESAMPLES)
    return Bounds(medians[outside], medians[-1 - outside])
