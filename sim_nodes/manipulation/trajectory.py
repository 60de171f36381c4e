"""Joint paths, and trajectories along them: from rest to rest, within limits of speed and acceleration.

A path is a curve through configurations. A trajectory is a path with a quintic time scaling, whose speed and
acceleration are zero at both ends. With fewer than three configurations, the path is a straight line. Otherwise it
is a monotone cubic of each joint, which stays between neighbouring values, so that limits that hold at the
configurations also hold between them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from sim_nodes.geometry import Array

SAMPLES = 200  # points of a path at which speeds and accelerations are compared with limits
SHORTEST = 0.04  # [s], also for a path without length


class TrajectoryPoint(NamedTuple):
    """Positions and velocities of the joints at a time, each of shape (n,)."""

    positions: Array  # [rad]
    velocities: Array  # [rad/s]


class Path:
    """A curve through configurations, parametrized from 0 to 1 in proportion to the motion of the joints.

    Args:
        configurations: At least two; neighbouring ones differ.

    Attributes:
        points: The configurations, shape (k, n).
        knots: Their path parameters, shape (k,).
    """

    def __init__(self, configurations: Sequence[Array] | Array) -> None:
        self.points: Array = np.array(configurations)
        points = self.points
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        self.knots: Array = np.concatenate([[0.0], np.cumsum(steps)]) / max(float(steps.sum()), 1e-12)
        if len(points) > 2:
            from scipy.interpolate import PchipInterpolator  # noqa: PLC0415 - slow to load, and seldom needed

            self._curve = PchipInterpolator(self.knots, points)
        else:
            self._curve = None
        self._start, self._way = points[0], points[-1] - points[0]

    def at(self, place: float) -> Array:
        """Return the configuration at a path parameter."""
        return self._start + place * self._way if self._curve is None else np.asarray(self._curve(place))

    def derivatives(self, places: Array) -> tuple[Array, Array]:
        """Return the first and second derivative by the parameter, each of shape (len(places), n)."""
        if self._curve is None:
            return np.tile(self._way, (len(places), 1)), np.zeros((len(places), len(self._way)))
        return np.asarray(self._curve(places, 1)), np.asarray(self._curve(places, 2))


class Trajectory:
    """A path in time, as fast as the limits allow.

    Args:
        path: The path.
        max_speed: Limit of each joint [rad/s].
        max_acceleration: Limit of each joint [rad/s^2].
    """

    def __init__(self, path: Path, max_speed: Array, max_acceleration: Array) -> None:
        self.path = path
        times = np.linspace(0.0, 1.0, SAMPLES)
        place, rate, change = _scaling(times)
        first, second = path.derivatives(place)
        # For a duration T, speeds scale with 1 / T and accelerations with 1 / T^2.
        speed = np.abs(first * rate[:, None]) / max_speed
        acceleration = np.abs(second * rate[:, None] ** 2 + first * change[:, None]) / max_acceleration
        self.duration = max(SHORTEST, float(speed.max()), float(np.sqrt(acceleration.max())))  # [s]

    def at(self, time: float) -> TrajectoryPoint:
        """Return the target at a time since the start [s]; at rest before and after."""
        unit = np.array([min(max(time / self.duration, 0.0), 1.0)])
        place, rate, _ = _scaling(unit)
        first, _ = self.path.derivatives(place)
        return TrajectoryPoint(self.path.at(float(place[0])), first[0] * rate[0] / self.duration)


def _scaling(time: Array) -> tuple[Array, Array, Array]:
    """Return the path parameter at times from 0 to 1, and its first and second derivative by time."""
    place = time**3 * (10.0 - 15.0 * time + 6.0 * time**2)
    rate = 30.0 * time**2 * (1.0 - time) ** 2
    change = 60.0 * time * (1.0 - time) * (1.0 - 2.0 * time)
    return place, rate, change
