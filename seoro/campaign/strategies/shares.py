"""Points of strategies as shares of axes, from 0 to less than 1."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from random import Random
from typing import Final, TypeAlias

from seoro.campaign.runs import Point
from seoro.campaign.space.axes import Axis

TRIES: Final = 100  # draws until constraints allow the values

Shares: TypeAlias = tuple[float, ...]
"""Share of each axis, from 0 to less than 1."""


def hypercube(size: int, axes: int, random: Random) -> Iterator[Shares]:
    """Yield the points of a Latin hypercube.

    Args:
        size: Number of points.
        axes: Number of axes.
        random: Source of random numbers.
    """
    parts = [random.sample(range(size), size) for _ in range(axes)]
    for point in zip(*parts, strict=True):
        yield tuple((part + random.random()) / size for part in point)


def point_at(axes: Sequence[Axis], shares: Shares) -> Point:
    """Return the point at shares of axes."""
    return Point({axis.path: axis.at(share) for axis, share in zip(axes, shares, strict=True)})
