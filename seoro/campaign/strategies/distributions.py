"""Distributions of an axis that learn, for the cross-entropy method; their values are shares of the axis."""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from random import Random
from typing import Final, Protocol

NARROWEST: Final = 0.03  # standard deviation, so that equal values do not end the search
KEPT: Final = 0.2  # share of the distribution before that stays


class Distribution(Protocol):
    """Distribution of shares; uniform before the first lesson."""

    def draw(self, random: Random) -> float:
        """Draw a share."""

    def learn(self, best: Sequence[float]) -> None:
        """Move to the shares of good points."""


class Normal:
    """Normal distribution within the bounds, for ordered values."""

    def __init__(self) -> None:
        self._mean = 0.5
        self._deviation = 0.0  # uniform

    def draw(self, random: Random) -> float:
        """Draw a share."""
        return draw_normal(self._mean, self._deviation, random) if self._deviation else random.random()

    def learn(self, best: Sequence[float]) -> None:
        """Move to the shares of good points."""
        kept = KEPT if self._deviation else 0.0
        deviation = max(NARROWEST, statistics.pstdev(best))
        self._mean = kept * self._mean + (1 - kept) * statistics.fmean(best)
        self._deviation = kept * self._deviation + (1 - kept) * deviation


def draw_normal(mean: float, deviation: float, random: Random) -> float:
    """Draw a share from a normal distribution within the bounds."""
    while True:
        share = random.gauss(mean, deviation)
        if 0.0 <= share < 1.0:
            return share


class Weights:
    """Weights of values without order.

    Args:
        number: Number of values.
    """

    def __init__(self, number: int) -> None:
        self._weights = [1 / number] * number

    def draw(self, random: Random) -> float:
        """Draw a share, the middle of a value."""
        number = len(self._weights)
        return (random.choices(range(number), self._weights)[0] + 0.5) / number

    def learn(self, best: Sequence[float]) -> None:
        """Move to the shares of good points."""
        number = len(self._weights)
        values = [int(share * number) for share in best]
        self._weights = [
            KEPT * weight + (1 - KEPT) * values.count(value) / len(best)
            for value, weight in enumerate(self._weights)
        ]
