"""Densities of good and of other points, for draws that are likely among the good ones only.

Each axis has densities of its own: kernels around the shares of points, and a uniform part, so that no share is
impossible. The best of some draws from the density of good points is the one with the largest ratio of both
densities (Bergstra, Bardenet, Bengio, Kégl, "Algorithms for hyper-parameter optimization", 2011).
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterator, Sequence
from random import Random
from typing import Final, Protocol

from seoro.campaign.strategies.distributions import NARROWEST, draw_normal
from seoro.campaign.strategies.shares import Shares

CANDIDATES: Final = 12  # draws, of which the best is used
_ALONE: Final = 0.3  # standard deviation that a single point stands for
_DENSEST: Final = 1.0 / math.sqrt(math.tau)  # of a normal distribution with the deviation 1


class Density(Protocol):
    """Density of the shares of an axis."""

    def draw(self, random: Random) -> float:
        """Draw a share."""

    def log(self, share: float) -> float:
        """Return the logarithm of the density at a share."""


class Kernels:
    """Density of ordered values: a normal distribution around each share, and a uniform one.

    Args:
        shares: Shares of points; at least one.
        axes: Number of axes of the space, for the width (Scott, "Multivariate density estimation", 1992).
    """

    def __init__(self, shares: Sequence[float], axes: int) -> None:
        self._shares = shares
        deviation = statistics.pstdev(shares) if len(shares) > 1 else _ALONE
        self._width = max(NARROWEST, deviation * len(shares) ** (-1 / (axes + 4)))

    def draw(self, random: Random) -> float:
        """Draw a share."""
        number = random.randrange(len(self._shares) + 1)
        if number == len(self._shares):
            return random.random()
        return draw_normal(self._shares[number], self._width, random)

    def log(self, share: float) -> float:
        """Return the logarithm of the density at a share."""
        near = sum(math.exp(-0.5 * ((share - each) / self._width) ** 2) for each in self._shares)
        return math.log((1.0 + near * _DENSEST / self._width) / (len(self._shares) + 1))


class Counts:
    """Density of values without order: their number among points, and one more of each.

    Args:
        shares: Shares of points.
        number: Number of values.
    """

    def __init__(self, shares: Sequence[float], number: int) -> None:
        self._weights = [1] * number
        for share in shares:
            self._weights[int(share * number)] += 1

    def draw(self, random: Random) -> float:
        """Draw a share, the middle of a value."""
        number = len(self._weights)
        return (random.choices(range(number), self._weights)[0] + 0.5) / number

    def log(self, share: float) -> float:
        """Return the logarithm of the density at a share."""
        number = len(self._weights)
        return math.log(self._weights[int(share * number)] * number / sum(self._weights))


def densities(points: Sequence[Shares], sizes: Sequence[int | None]) -> list[Density]:
    """Return the density of each axis.

    Args:
        points: Points; at least one.
        sizes: Number of values of each axis without order; None for others.
    """
    found: list[Density] = []
    for index, size in enumerate(sizes):
        shares = [point[index] for point in points]
        found.append(Kernels(shares, len(sizes)) if size is None else Counts(shares, size))
    return found


def draw_likely(good: Sequence[Density], others: Sequence[Density], random: Random) -> Iterator[Shares]:
    """Yield draws from the density of good points, the ones that are least likely among others first."""
    drawn = [tuple(axis.draw(random) for axis in good) for _ in range(CANDIDATES)]

    def ratio(shares: Shares) -> float:
        of_axes = zip(good, others, shares, strict=True)
        return sum(likely.log(share) - other.log(share) for likely, other, share in of_axes)

    yield from sorted(drawn, key=ratio, reverse=True)
