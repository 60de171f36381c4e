"""Sets of particles: their number, their choice by weight, and the place where most of them are."""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from seoro.deferred import dataclass
from sim_nodes.geometry import Array, Indices, Pose2, wrap

BIN = (0.5, 0.5, math.radians(10.0))  # [m, m, rad]
NEAR = (1.0, 1.0, math.radians(45.0))  # [m, m, rad] from the densest place: one hypothesis
SIDE = 1 << 16  # exceeds the number of bins along an axis


@dataclass(frozen=True)
class Estimate:
    """The densest place of a set of particles.

    Attributes:
        pose: Mean of the particles there.
        covariance: Covariance of x, y and yaw there, shape (3, 3) [m^2, m rad, rad^2].
        share: Share of all particles, up to 1.
    """

    pose: Pose2
    covariance: Array
    share: float

    @cached_property
    def deviation(self) -> float:
        """Standard deviation of the position [m], over both axes."""
        return math.sqrt(float(self.covariance[0, 0] + self.covariance[1, 1]))


def bins(particles: Array) -> Indices:
    """Return the bin number of each particle, shape (n,)."""
    # One column after the other, because rows of three take several times as long.
    x, y, yaw = (np.floor(particles[:, axis] / size).astype(np.int64) for axis, size in enumerate(BIN))
    turns = round(2.0 * math.pi / BIN[2])
    numbers: Indices = ((x + SIDE // 2) * SIDE + y + SIDE // 2) * turns + yaw % turns
    return numbers


def particles_needed(occupied: Array, err: float, z: float) -> Array:
    """Return the number of particles that bounds the error of a distribution over bins (Fox 2003, equation 11).

    Args:
        occupied: Number of occupied bins.
        err: Maximum error: Kullback-Leibler distance to the true distribution.
        z: Quantile of the normal distribution for the probability of that bound.
    """
    freedom = np.maximum(occupied - 1.0, 1.0)
    part = 2.0 / (9.0 * freedom)
    needed: Array = freedom / (2.0 * err) * (1.0 - part + np.sqrt(part) * z) ** 3
    return needed


def adapted_count(where: Indices, least: int, most: int, err: float, z: float) -> int:
    """Return how many particles, in the order in which they were drawn, are sufficient.

    Args:
        where: Bins of the particles, in order.
        least: Minimum number.
        most: Maximum number.
        err: See `particles_needed`.
        z: See `particles_needed`.
    """
    _, first = np.unique(where, return_index=True)
    fresh = np.zeros(len(where), dtype=np.int64)
    fresh[first] = 1
    enough = particles_needed(np.cumsum(fresh).astype(np.float64), err, z) <= np.arange(1, len(where) + 1)
    count = int(enough.argmax()) + 1 if enough.any() else len(where)
    return min(max(count, least), most)


def draw(weights: Array, count: int, offset: float) -> Indices:
    """Choose particles by weight with low variance, from one random number (Thrun et al. 2005, table 4.4).

    Args:
        weights: Weights with sum 1.
        count: Number of particles to choose.
        offset: Random number in [0, 1).
    """
    chosen: Indices = np.searchsorted(np.cumsum(weights), (offset + np.arange(count)) / count)
    return np.minimum(chosen, len(weights) - 1)


def occupied(where: Indices) -> int:
    """Return the number of different bins."""
    numbers = np.sort(where)
    return 1 + int(np.count_nonzero(numbers[1:] != numbers[:-1]))


def estimate(particles: Array, where: Indices) -> Estimate:
    """Return the densest place: the fullest bin and its surroundings.

    Args:
        particles: Poses (x, y, yaw), shape (n, 3).
        where: Their bins.
    """
    core = _some(particles, where == _fullest(where))
    here = _mean(core)
    x, y, yaw = _offsets(particles, here)
    near = (np.abs(x) < NEAR[0]) & (np.abs(y) < NEAR[1]) & (np.abs(yaw) < NEAR[2])
    cluster = _some(particles, near)
    pose = here if cluster is core else _mean(cluster)
    deviation = np.column_stack(_offsets(cluster, pose))
    covariance: Array = deviation.T @ deviation / len(cluster)
    return Estimate(pose, covariance, len(cluster) / len(particles))


def _fullest(where: Indices) -> int:
    """Return the bin with the most particles, the first of several."""
    numbers = np.sort(where)
    ends = [*(np.flatnonzero(numbers[1:] != numbers[:-1]) + 1).tolist(), len(numbers)]
    sizes = [end - start for start, end in zip([0, *ends], ends, strict=False)]
    return int(numbers[ends[sizes.index(max(sizes))] - 1])


def _some(particles: Array, chosen: NDArray[np.bool_]) -> Array:
    """Return the chosen particles, which are often all of them."""
    return particles if chosen.all() else particles[chosen]


def _offsets(particles: Array, pose: Pose2) -> tuple[Array, Array, Array]:
    """Return the differences of x, y and yaw from a pose."""
    x, y, yaw = (particles[:, axis] - value for axis, value in enumerate(pose))
    return x, y, wrap(yaw)


def _mean(particles: Array) -> Pose2:
    # Sums, because `mean` takes twice as long for few particles.
    count, yaw = len(particles), particles[:, 2]
    x, y, _ = (np.add.reduce(particles) / count).tolist()
    return Pose2(x, y, math.atan2(np.add.reduce(np.sin(yaw)) / count, np.add.reduce(np.cos(yaw)) / count))
