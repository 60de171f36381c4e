"""Planar lidar: scans of ranges as in `sensor_msgs/LaserScan`."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from seoro.bridges.wire import Quantity
from sim_nodes.geometry import Array, Pose2
from sim_nodes.noise import Noise
from sim_nodes.robots.declaration import LidarDeclaration
from sim_nodes.sensors.sensor_pipeline import Sensor, Values, period_of, within

CastRays = Callable[[Array, float], Array]
"""Returns ranges along directions in the lidar's frame up to a limit, as `Engine.cast_rays` for one robot."""


@dataclass(frozen=True)
class Scan:
    """One turn of a lidar.

    Ranges and end points are infinite without a return.
    """

    ranges: Array  # [m], shape (n,)
    angles: Array  # of the beams around the lidar, in the base's frame [rad], shape (n,)
    mount: Pose2  # of the lidar in the base's frame
    x: Array  # end points of the beams in the base's frame [m], shape (n,)
    y: Array

    @cached_property
    def hit(self) -> NDArray[np.bool_]:
        """Whether each beam has a return, shape (n,)."""
        return np.isfinite(self.ranges)

    @cached_property
    def is_complete(self) -> bool:
        """Whether all beams have a return."""
        return bool(self.hit.all())


_NOTHING = np.zeros(0)
BLIND = Scan(_NOTHING, _NOTHING, Pose2(0.0, 0.0, 0.0), _NOTHING, _NOTHING)
"""The scan of a robot without a lidar."""


class Lidar(Sensor[Scan]):
    """The lidar of a robot.

    Args:
        declaration: Declaration of the lidar.
        noise: Source of random numbers.
        cast: Casts its beams.
    """

    quantities = (Quantity.LENGTH,)

    def __init__(self, declaration: LidarDeclaration, noise: Noise, cast: CastRays) -> None:
        self._declaration = declaration
        self._noise = noise
        self._cast = cast
        angles = np.linspace(-math.pi, math.pi, declaration.beams, endpoint=False)
        self._directions = np.column_stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)])
        self._mount = Pose2(declaration.x, declaration.y, declaration.yaw)
        self.bearings = angles + declaration.yaw
        self._cos, self._sin = np.cos(self.bearings), np.sin(self.bearings)
        self.period = period_of(declaration.rate)
        self.limits = (declaration.min_range, declaration.max_range)

    def read(self, tick: int) -> Scan:
        """Return a scan with the noise of a tick."""
        declaration, random = self._declaration, self._noise.at(tick)
        ranges = self._cast(self._directions, declaration.max_range)
        ranges = ranges + random.normal(0.0, declaration.noise, len(ranges))
        if declaration.resolution > 0.0:
            ranges = np.round(ranges / declaration.resolution) * declaration.resolution
        if declaration.dropout > 0.0:
            ranges[random.random(len(ranges)) < declaration.dropout] = np.inf
        return self._scan(ranges)

    def values(self, data: Scan) -> Values:
        """Return the ranges."""
        return {Quantity.LENGTH: data.ranges}

    def with_values(self, data: Scan, values: Values) -> Scan:
        """Return the scan with other ranges."""
        return self._scan(values[Quantity.LENGTH])

    def _scan(self, ranges: Array) -> Scan:
        """Return the scan of ranges; ranges out of bounds are without a return."""
        ranges = within(ranges, self.limits)
        # Beams without a return have infinite end points, also along the axes, where inf * 0 is NaN.
        hit = np.isfinite(ranges)
        finite = np.where(hit, ranges, 0.0)
        x = np.where(hit, self._mount.x + finite * self._cos, np.inf)
        y = np.where(hit, self._mount.y + finite * self._sin, np.inf)
        return Scan(ranges, self.bearings, self._mount, x, y)
