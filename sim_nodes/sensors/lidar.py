"""Planar lidar: scans of ranges as in `sensor_msgs/LaserScan`."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from seoro.bridges.wire import Quantity
from seoro.deferred import dataclass
from sim_nodes.geometry import Array, Pose2
from sim_nodes.noise import Noise
from sim_nodes.physics import Engine
from sim_nodes.ray_bundles import RayBundle, cast
from sim_nodes.robots.declaration import LidarDeclaration
from sim_nodes.sensors.sensor_pipeline import Sensor, Values, period_of, within


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
        robot: Name of its robot.
        engine: Engine that casts its beams.

    Attributes:
        declaration: Its declaration.
        engine: See above.
        beams: Its beams.
    """

    quantities = (Quantity.LENGTH,)

    def __init__(self, declaration: LidarDeclaration, noise: Noise, robot: str, engine: Engine) -> None:
        self.declaration = declaration
        self.engine = engine
        self._noise = noise
        angles = np.linspace(-math.pi, math.pi, declaration.beams, endpoint=False)
        directions = np.column_stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)])
        self.beams = RayBundle(robot, declaration.link, directions, declaration.max_range)
        self._mount = Pose2(declaration.x, declaration.y, declaration.yaw)
        self.bearings = angles + declaration.yaw
        self._cos, self._sin = np.cos(self.bearings), np.sin(self.bearings)
        self.period = period_of(declaration.rate)
        self.limits = (declaration.min_range, declaration.max_range)

    def read(self, tick: int) -> Scan:
        """Return a scan with the noise of a tick."""
        return read_together([self], tick)[0]

    def errors(self, tick: int) -> tuple[Array, NDArray[np.bool_] | None]:
        """Return the errors of ranges in a tick [m], and which beams have no return, if that happens."""
        declared, random = self.declaration, self._noise.at(tick)
        noise = random.normal(0.0, declared.noise, declared.beams)
        return noise, random.random(declared.beams) < declared.dropout if declared.dropout > 0.0 else None

    def values(self, data: Scan) -> Values:
        """Return the ranges."""
        return {Quantity.LENGTH: data.ranges}

    def with_values(self, data: Scan, values: Values) -> Scan:
        """Return the scan with other ranges."""
        return self.scans(values[Quantity.LENGTH][None])[0]

    def scans(self, ranges: Array) -> list[Scan]:
        """Return the scans of ranges, shape (scans, n) [m]; ranges out of bounds are without a return."""
        ranges = within(ranges, self.limits)
        # Beams without a return have infinite end points, also along the axes, where inf * 0 is NaN.
        hit = np.isfinite(ranges)
        finite = np.where(hit, ranges, 0.0)
        x = np.where(hit, self._mount.x + finite * self._cos, np.inf)
        y = np.where(hit, self._mount.y + finite * self._sin, np.inf)
        turns = zip(ranges, x, y, strict=True)
        return [Scan(seen, self.bearings, self._mount, ends_x, ends_y) for seen, ends_x, ends_y in turns]


def read_together(lidars: Sequence[Lidar], tick: int) -> list[Scan]:
    """Return the scans of lidars of one engine with the noise of a tick, as each of them alone reads it."""
    cast_ranges = cast(lidars[0].engine, [lidar.beams for lidar in lidars])
    kinds: dict[int, list[int]] = defaultdict(list)
    for number, lidar in enumerate(lidars):
        kinds[id(lidar.declaration)].append(number)
    found: dict[int, Scan] = {}
    for numbers in kinds.values():
        some = [lidars[number] for number in numbers]
        scans = _measured(some, np.array([cast_ranges[number] for number in numbers]), tick)
        found.update(zip(numbers, scans, strict=True))
    return [found[number] for number in range(len(lidars))]


def _measured(lidars: Sequence[Lidar], ranges: Array, tick: int) -> list[Scan]:
    """Return the scans of lidars with one declaration, by their true ranges, shape (lidars, n) [m]."""
    declared = lidars[0].declaration
    errors, dropped = zip(*(lidar.errors(tick) for lidar in lidars), strict=True)
    ranges = ranges + np.array(errors)
    if declared.resolution > 0.0:
        ranges = np.round(ranges / declared.resolution) * declared.resolution
    for row, lost in zip(ranges, dropped, strict=True):
        if lost is not None:
            row[lost] = np.inf
    return lidars[0].scans(ranges)
