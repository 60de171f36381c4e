"""Ranging sensors in space: 3D lidar and sonar. Both cast rays from their mount on a link."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from seoro.bridges.wire import Quantity
from seoro.deferred import dataclass
from sim_nodes.geometry import Array, rotation_matrix
from sim_nodes.noise import Noise
from sim_nodes.physics import Engine
from sim_nodes.robots.sensor_declarations import Lidar3dDeclaration, RangingDeclaration, SonarDeclaration
from sim_nodes.sensors.sensor_pipeline import Sensor, Values, period_of, within

GOLDEN_ANGLE = math.pi * (3.0 - math.sqrt(5.0))  # [rad]
CONE_RAYS = 128


def beam_directions(declaration: Lidar3dDeclaration) -> Array:
    """Return the unit vectors of the beams in the lidar's frame, ring by ring from below, shape (n, 3).

    The beams of a full turn are at equal angles, so the last one stops short of the first.
    """
    full = declaration.end - declaration.start >= 2.0 * math.pi
    bearings = np.linspace(declaration.start, declaration.end, declaration.beams, endpoint=not full)
    elevations = np.linspace(declaration.lowest, declaration.highest, declaration.rings)
    up, around = (grid.ravel() for grid in np.meshgrid(elevations, bearings, indexing="ij"))
    return np.column_stack([np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)])


def cone_directions(aperture: float, count: int = CONE_RAYS) -> Array:
    """Return unit vectors that fill a cone about the x axis evenly, shape (count, 3).

    They follow a spiral at the golden angle [Vogel 1979, A better way to construct the sunflower head].

    Args:
        aperture: Full angle of the cone [rad].
        count: Number of vectors; the first is the axis, the last ones are at the edge.
    """
    index = np.arange(count)
    cos = 1.0 - (1.0 - math.cos(aperture / 2.0)) * index / (count - 1)
    sin, turn = np.sqrt(1.0 - cos**2), index * GOLDEN_ANGLE
    return np.column_stack([cos, sin * np.cos(turn), sin * np.sin(turn)])


class RaySensor:
    """Casts rays from a mount on a link.

    Args:
        robot: Name of the robot, which the rays ignore.
        declaration: Declaration of the sensor.
        engine: Engine that simulates the robot.
        directions: Unit vectors in the sensor's frame, shape (n, 3).
    """

    def __init__(self, robot: str, declaration: RangingDeclaration, engine: Engine, directions: Array) -> None:
        turned = directions @ rotation_matrix(declaration.orientation).T
        self._cast = partial(
            engine.cast_rays, robot, declaration.link, turned, declaration.max_range, declaration.position
        )

    def ranges(self) -> Array:
        """Return the true distances [m], shape (n,); infinite without a hit."""
        return self._cast()


@dataclass(frozen=True)
class Cloud:
    """One scan of a 3D lidar.

    Attributes:
        ranges: Distances along the beams, ring by ring from below [m], shape (rings * beams,); infinite without a
            return.
        directions: Unit vectors of the beams in the lidar's frame, shape (rings * beams, 3).
        rings: Number of rings.
    """

    ranges: Array
    directions: Array
    rings: int


class Lidar3d(Sensor[Cloud]):
    """A lidar with several rings.

    Args:
        robot: Name of the robot.
        declaration: Declaration of the lidar.
        noise: Source of random numbers.
        engine: Engine that simulates the robot.
    """

    quantities = (Quantity.LENGTH,)

    def __init__(self, robot: str, declaration: Lidar3dDeclaration, noise: Noise, engine: Engine) -> None:
        self._declaration = declaration
        self._noise = noise
        self._directions = beam_directions(declaration)
        self._rays = RaySensor(robot, declaration, engine, self._directions)
        self.bearings = np.arctan2(self._directions[:, 1], self._directions[:, 0])
        self.period = period_of(declaration.rate)
        self.limits = (declaration.min_range, declaration.max_range)

    def read(self, tick: int) -> Cloud:
        """Return a scan with the noise of a tick."""
        declaration, random = self._declaration, self._noise.at(tick)
        ranges = self._rays.ranges()
        ranges = ranges + random.normal(0.0, declaration.noise, len(ranges))
        if declaration.dropout > 0.0:
            ranges[random.random(len(ranges)) < declaration.dropout] = np.inf
        return self._cloud(ranges)

    def values(self, data: Cloud) -> Values:
        """Return the ranges."""
        return {Quantity.LENGTH: data.ranges}

    def with_values(self, data: Cloud, values: Values) -> Cloud:
        """Return the scan with other ranges."""
        return self._cloud(values[Quantity.LENGTH])

    def _cloud(self, ranges: Array) -> Cloud:
        return Cloud(within(ranges, self.limits), self._directions, self._declaration.rings)


@dataclass(frozen=True)
class Echo:
    """Distance that a sonar measures [m]; infinite without an echo."""

    distance: float


class Sonar(Sensor[Echo]):
    """An ultrasonic sensor; it has one beam, straight ahead.

    Args:
        robot: Name of the robot.
        declaration: Declaration of the sensor.
        noise: Source of random numbers.
        engine: Engine that simulates the robot.
    """

    quantities = (Quantity.LENGTH,)

    def __init__(self, robot: str, declaration: SonarDeclaration, noise: Noise, engine: Engine) -> None:
        self._declaration = declaration
        self._noise = noise
        self._rays = RaySensor(robot, declaration, engine, cone_directions(declaration.aperture))
        self.bearings = np.zeros(1)
        self.period = period_of(declaration.rate)
        self.limits = (declaration.min_range, declaration.max_range)

    def read(self, tick: int) -> Echo:
        """Return a distance with the noise of a tick."""
        random = self._noise.at(tick)
        nearest = self._rays.ranges().min() + random.normal(0.0, self._declaration.noise)
        return self._echo(np.array([np.inf if random.random() < self._declaration.dropout else nearest]))

    def values(self, data: Echo) -> Values:
        """Return the distance."""
        return {Quantity.LENGTH: np.array([data.distance])}

    def with_values(self, data: Echo, values: Values) -> Echo:
        """Return another distance."""
        return self._echo(values[Quantity.LENGTH])

    def _echo(self, distances: Array) -> Echo:
        return Echo(float(within(distances, self.limits)[0]))
