"""Declarations of the sensors in the list `sensors` of a robot, which any link may carry.

A sensor's frame has x ahead, y to the left and z up, as a robot's base (REP 103).
"""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

from pydantic import Field, NonNegativeFloat, PositiveFloat, PositiveInt, model_validator

from sim_nodes.files import NAME, Declared
from sim_nodes.geometry import Quaternion, Vector, quaternion

MAX_RATE = 50.0  # [Hz], one sample for each tick
MAX_RAYS = 65_536  # of a scan
MAX_SENSORS = 16  # of a robot

Probability = Annotated[float, Field(ge=0.0, le=1.0)]


class MountedSensor(Declared):
    """A sensor at a pose in the frame of a link."""

    name: str = Field(pattern=NAME)
    link: str
    x: float = 0.0  # mount in the link's frame [m]
    y: float = 0.0
    z: float = 0.0
    roll: float = 0.0  # [rad]
    pitch: float = 0.0
    yaw: float = 0.0
    rate: float = Field(10.0, gt=0.0, le=MAX_RATE)  # [Hz]

    @property
    def position(self) -> Vector:
        """Position in the link's frame [m]."""
        return self.x, self.y, self.z

    @property
    def orientation(self) -> Quaternion:
        """Orientation in the link's frame."""
        return quaternion(self.roll, self.pitch, self.yaw)


class RangingDeclaration(MountedSensor):
    """A sensor that measures distances within limits."""

    min_range: PositiveFloat = 0.05  # [m]
    max_range: PositiveFloat
    noise: NonNegativeFloat = 0.0  # standard deviation of a distance [m]

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.min_range >= self.max_range:
            raise ValueError(
                f"`min_range` {self.min_range:g} of {self.name!r} is not below `max_range` {self.max_range:g}"
            )
        return self


class Lidar3dDeclaration(RangingDeclaration):
    """A lidar with several rings of beams, at equal angles between two elevations."""

    kind: Literal["lidar_3d"]
    rings: PositiveInt
    beams: PositiveInt  # of a ring
    lowest: float = Field(-math.pi / 12, gt=-math.pi / 2, lt=math.pi / 2)  # elevation of the rings [rad]
    highest: float = Field(math.pi / 12, gt=-math.pi / 2, lt=math.pi / 2)
    start: float = Field(-math.pi, ge=-math.pi, le=math.pi)  # bearing of the beams [rad]
    end: float = Field(math.pi, ge=-math.pi, le=math.pi)
    dropout: Probability = 0.0  # probability that a beam has no return

    @model_validator(mode="after")
    def _bounded(self) -> Self:
        if self.rings * self.beams > MAX_RAYS:
            raise ValueError(f"{self.name!r} has {self.rings * self.beams} beams; expected at most {MAX_RAYS}")
        if self.lowest > self.highest or self.start >= self.end:
            raise ValueError(f"invalid angles of {self.name!r}; expected `lowest` <= `highest`, `start` < `end`")
        return self


class SonarDeclaration(RangingDeclaration):
    """An ultrasonic sensor, which measures the distance of the nearest surface in a cone."""

    kind: Literal["sonar"]
    aperture: float = Field(math.radians(30.0), gt=0.0, le=math.pi)  # full angle of the cone [rad]
    dropout: Probability = 0.0  # probability of no echo


SensorDeclaration = Annotated[Lidar3dDeclaration | SonarDeclaration, Field(discriminator="kind")]
"""Any sensor of the list `sensors`."""
