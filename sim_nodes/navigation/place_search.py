"""Search of the whole map for the places where a scan fits best.

Particles may gather in a place that only looks alike. So a place is compared with all others before it is
accepted. Every free cell of a coarse grid, in every direction, is rated with some beams. The best places, apart
from each other, are refined and rated with all beams.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from seoro.deferred import dataclass
from sim_nodes.geometry import Array, Pose2, wrap
from sim_nodes.sensors.lidar import Scan

HEADINGS = 72
COARSE_BEAMS = 40
PLACES = 24  # that are refined
APART = (0.5, 0.5)  # [m], [rad]; places that are nearer in both are the same
STEPS = ((0.05, 0.05), (0.02, 0.02), (0.01, 0.01))  # [m], [rad] of the rounds of refinement

RatePoints = Callable[[Array, Array], Array]
"""Returns the log likelihood that beams end at points x, y in `map`, with the shape of `x`."""


@dataclass(frozen=True)
class Place:
    """A pose, and the mean log likelihood of the beams there."""

    pose: Pose2
    fit: float

    def is_same(self, other: Pose2) -> bool:
        """Whether a pose is at this place."""
        near = self.pose.distance(other.x, other.y) < APART[0]
        return near and abs(wrap(self.pose.yaw - other.yaw)) < APART[1]


def fit_of(poses: Array, scan: Scan, rate: RatePoints, beams: int) -> Array:
    """Return the mean log likelihood of evenly spaced beams at poses of shape (n, 3)."""
    hits = np.flatnonzero(scan.hit)[:: max(1, int(scan.hit.sum()) // beams)]
    bx, by = scan.x[hits], scan.y[hits]
    x, y, yaw = (column[:, None] for column in poses.T)
    cos, sin = np.cos(yaw), np.sin(yaw)
    fit: Array = rate(x + cos * bx - sin * by, y + sin * bx + cos * by).mean(axis=1)
    return fit


def best_places(points: Array, scan: Scan, rate: RatePoints) -> list[Place]:
    """Return the places where a scan fits best, the best one first.

    Args:
        points: Points of free floor, shape (n, 2) [m].
        scan: Scan with returns.
        rate: Likelihood of beams.
    """
    headings = np.linspace(-math.pi, math.pi, HEADINGS, endpoint=False)
    fits = np.stack([fit_of(_at(points, heading), scan, rate, COARSE_BEAMS) for heading in headings])
    found: list[Place] = []
    for index in np.argsort(-fits, axis=None, kind="stable"):
        heading, point = divmod(int(index), len(points))
        pose = Pose2(float(points[point, 0]), float(points[point, 1]), float(headings[heading]))
        if not any(place.is_same(pose) for place in found):
            found.append(Place(pose, float(fits[heading, point])))
        if len(found) == PLACES:
            break
    return sorted((refined(place.pose, scan, rate) for place in found), key=lambda place: -place.fit)


def _at(points: Array, heading: float) -> Array:
    return np.column_stack([points, np.full(len(points), heading)])


def refined(pose: Pose2, scan: Scan, rate: RatePoints) -> Place:
    """Return the best place around a pose."""
    around = np.stack(np.meshgrid(*[np.arange(-2.0, 3.0)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    best, fit = np.array(pose), -math.inf
    for distance, angle in STEPS:
        tried = best + around * (distance, distance, angle)
        fits = fit_of(tried, scan, rate, len(scan.ranges))
        chosen = int(fits.argmax())
        best, fit = tried[chosen], float(fits[chosen])
    x, y, yaw = best.tolist()
    return Place(Pose2(x, y, wrap(yaw)), fit)
