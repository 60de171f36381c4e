"""Sets of weighted poses: how many are needed, drawing them, and what they say together.

Particles are arrays of shape (n, 3): x [m], y [m], yaw [rad] in the map. For counting and for finding where they
are densest, poses fall into bins of the sizes that Nav2's AMCL has.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim_nodes.geometry import Array, Pose2

BIN = (0.5, 0.5, math.radians(10.0))  # [m, m, rad]
NEAR = (1.0, math.radians(45.0))  # [m], [rad] from where particles are densest: what counts as one hypothesis
SIDE = 1 << 16  # more bins than there are along an axis

Indices = NDArray[np.int64]


@dataclass(frozen=True)
class Estimate:
    """Where particles are densest.

    Attributes:
        pose: The mean of the particles there.
        covariance: Of x, y and yaw there, shape (3, 3) [m^2, m rad, rad^2].
        share: How many of all particles are there, up to 1.
    """

    pose: Pose2
    covariance: Array
    share: float

    @property
    def deviation(self) -> float:
        """Standard deviation of the position [m], of both axes together."""
        return math.sqrt(float(self.covariance[0, 0] + self.covariance[1, 1]))


def bins(particles: Array) -> Indices:
    """The bin of each particle, as a number, shape (n,)."""
    x, y, yaw = (np.floor(particles[:, i] / BIN[i]).astype(np.int64) for i in range(3))
    turns = round(2.0 * math.pi / BIN[2])
    numbers: Indices = ((x + SIDE // 2) * SIDE + y + SIDE // 2) * turns + yaw % turns
    return numbers


def particles_needed(occupied: Array, err: float, z: float) -> Array:
    """How many particles keep the error of a distribution over bins small (Fox 2003, equation 11).

    Args:
        occupied: Numbers of bins with particles.
        err: Largest error, as Kullback-Leibler distance to the true distribution.
        z: Quantile of the normal distribution for the certainty that it is kept.
    """
    freedom = np.maximum(occupied - 1.0, 1.0)
    part = 2.0 / (9.0 * freedom)
    needed: Array = freedom / (2.0 * err) * (1.0 - part + np.sqrt(part) * z) ** 3
    return needed


def adapted_count(where: Indices, least: int, most: int, err: float, z: float) -> int:
    """How many of some particles, in the order in which they were drawn, are enough.

    Args:
        where: The bins of the particles in order.
        least: So many at least.
        most: So many at most.
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
    """Choose particles by weight, evenly, with one random number for all (Thrun et al. 2005, table 4.4).

    Args:
        weights: Sum 1.
        count: How many to choose.
        offset: The random number, in [0, 1).
    """
    chosen: Indices = np.searchsorted(np.cumsum(weights), (offset + np.arange(count)) / count)
    return chosen.clip(0, len(weights) - 1)


def estimate(particles: Array) -> Estimate:
    """Where the particles are densest: the fullest bin and what is near its mean."""
    where = bins(particles)
    numbers, counts = np.unique(where, return_counts=True)
    here = _mean(particles[where == numbers[counts.argmax()]])
    offset = particles - np.array(here)
    offset[:, 2] = _wrapped(offset[:, 2])
    near = (np.abs(offset[:, 0]) < NEAR[0]) & (np.abs(offset[:, 1]) < NEAR[0]) & (np.abs(offset[:, 2]) < NEAR[1])
    cluster = particles[near]
    pose = _mean(cluster)
    deviation = cluster - np.array(pose)
    deviation[:, 2] = _wrapped(deviation[:, 2])
    covariance: Array = deviation.T @ deviation / len(cluster)
    return Estimate(pose, covariance, len(cluster) / len(particles))


def _mean(particles: Array) -> Pose2:
    x, y, _ = particles.mean(axis=0).tolist()
    return Pose2(x, y, math.atan2(np.sin(particles[:, 2]).mean(), np.cos(particles[:, 2]).mean()))


def _wrapped(angles: Array) -> Array:
    wrapped: Array = (angles + math.pi) % (2.0 * math.pi) - math.pi
    return wrapped
