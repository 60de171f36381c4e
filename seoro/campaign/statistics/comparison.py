"""Paired comparison of two campaigns: the same variants and seeds, another version."""

from __future__ import annotations

import math
from collections.abc import Sequence

from seoro.campaign.statistics.beta import beta_quantile, log_choose
from seoro.campaign.statistics.rates import CONFIDENCE, Bounds


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
    tail = sum(math.exp(log_choose(changed, count) - changed * math.log(2.0)) for count in range(fewer + 1))
    return min(1.0, 2.0 * tail)


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


def median_change(changes: Sequence[float], confidence: float = CONFIDENCE) -> Bounds:
    """Return an interval for the median change between paired measurements, by the percentile bootstrap.

    The distribution of the medians of all resamples is known, so none are drawn. Of `n` draws with replacement,
    the median is at most the `k`-th change if a binomial variable with the share `k / n` reaches half of `n`.
    See Efron, "Bootstrap Methods: Another Look at the Jackknife", Annals of Statistics 7, 1979, section 3.

    Args:
        changes: Change of each pair, at least one.
        confidence: Approximate probability that the interval contains the median.
    """
    ordered, number = sorted(changes), len(changes)
    outside = (1.0 - confidence) / 2.0
    low = _quantile_of_medians(outside, (number + 1) // 2, number)
    high = _quantile_of_medians(1.0 - outside, number // 2 + 1, number)
    return Bounds(ordered[low - 1], ordered[high - 1])


def _quantile_of_medians(share: float, half: int, number: int) -> int:
    """Return the rank, from 1, that a share of the medians of resamples reach at most."""
    return min(number, math.ceil(number * beta_quantile(share, half, number - half + 1)))
