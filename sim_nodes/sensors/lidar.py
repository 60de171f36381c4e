"""A planar lidar: one scan of ranges, as `sensor_msgs/LaserScan` has it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim_nodes.geometry import Array, Pose2
from sim_nodes.noise import Noise
from sim_nodes.physics import Engine
from sim_nodes.robots.declaration import LidarDeclaration


@dataclass(frozen=True)
class Scan:
    """One turn of a lidar.

    Ranges and ends are infinite where nothing was hit.
    """

    ranges: Array  # [m], shape (n,)
    angles: Array  # of the beams about the lidar, in the base's frame [rad], shape (n,)
    mount: Pose2  # of the lidar in the base's frame
    x: Array  # of the ends of the beams, in the base's frame [m], shape (n,)
    y: Array

    @property
    def hit(self) -> NDArray[np.bool_]:
        """Which beams hit something, shape (n,)."""
        hit: NDArray[np.bool_] = np.isfinite(self.ranges)
        return hit


class Lidar:
    """The lidar of a robot."""

    def __init__(self, declaration: LidarDeclaration, noise: Noise) -> None:
        self._declaration = declaration
        self._noise = noise
        angles = np.linspace(-math.pi, math.pi, declaration.beams, endpoint=False)
        self._directions = np.column_stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)])
        self._mount = Pose2(declaration.x, declaration.y, declaration.yaw)
        self._angles = angles + declaration.yaw
        self._cos, self._sin = np.cos(self._angles), np.sin(self._angles)

    def scan(self, engine: Engine, robot: str, tick: int) -> Scan:
        """A scan with the noise of a tick; what is nearer than the least range is not seen."""
        declaration = self._declaration
        ranges = engine.cast_rays(robot, self._directions, declaration.max_range)
        ranges = ranges + self._noise.at(tick).normal(0.0, declaration.noise, len(ranges))
        ranges[(ranges < declaration.min_range) | (ranges > declaration.max_range)] = np.inf
        # Beams without a hit end nowhere, also along the axes, where inf * 0 would be no number.
        hit = np.isfinite(ranges)
        finite = np.where(hit, ranges, 0.0)
        x = np.where(hit, self._mount.x + finite * self._cos, np.inf)
        y = np.where(hit, self._mount.y + finite * self._sin, np.inf)
        return Scan(ranges, self._angles, self._mount, x, y)
