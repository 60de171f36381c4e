"""Sets of particles: their number, their choice by weight, and the place where most of them are."""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np

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
    x, y, yaw = np.floor(particles / BIN).astype(np.int64).T
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
    return chosen.clip(0, len(weights) - 1)


def estimate(particles: Array) -> Estimate:
    """Return the densest place: the fullest bin and its surroundings."""
    where = bins(particles)
    numbers = np.sort(where)
    ends = np.append(np.flatnonzero(numbers[1:] != numbers[:-1]) + 1, len(numbers))
    fullest = numbers[ends[np.diff(ends, prepend=0).argmax()] - 1]
    here = _mean(particles[where == fullest])
    offset = particles - np.array(here)
    offset[:, 2] = wrap(offset[:, 2])
    x, y, yaw = np.abs(offset.T)
    cluster = particles[(x < NEAR[0]) & (y < NEAR[1]) & (yaw < NEAR[2])]
    pose = _mean(cluster)
    deviation = cluster - np.array(pose)
    deviation[:, 2] = wrap(deviation[:, 2])
    covariance: Array = deviation.T @ deviation / len(cluster)
    return Estimate(pose, covariance, len(cluster) / len(particles))


def _mean(particles: Array) -> Pose2:
    # Sums, because `mean` takes twice as long for few particles.
    count, yaw = len(particles), particles[:, 2]
    x, y, _ = (np.add.reduce(particles) / count).tolist()
    return Pose2(x, y, math.atan2(np.add.reduce(np.sin(yaw)) / count, np.add.reduce(np.cos(yaw)) / count))
