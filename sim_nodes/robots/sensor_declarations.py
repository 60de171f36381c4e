"""Declarations of the sensors in the list `sensors` of a robot, which any link may carry.

A sensor's frame has x ahead, y to the left and z up, as a robot's base (REP 103).
"""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

from pydantic import Field, NonNegativeFloat, PositiveFloat, PositiveInt, model_validator

from sim_nodes.files import NAME, Declared
from sim_nodes.geometry import Quaternion, Vector, quaternion
from sim_nodes.views import MAX_FOV, MAX_SIZE, MIN_FOV, MIN_SIZE, Lens

MAX_RATE = 50.0  # [Hz], one sample for each tick
MAX_RAYS = 65_536  # of a scan
MAX_SENSORS = 16  # of a robot
MAX_PIXELS = 1 << 20

Probability = Annotated[float, Field(ge=0.0, le=1.0)]


class LinkPart(Declared):
    """A named part of a link."""

    name: str = Field(pattern=NAME)
    link: str


class Mount(Declared):
    """A pose in the frame of a link."""

    x: float = 0.0  # [m]
    y: float = 0.0
    z: float = 0.0
    roll: float = 0.0  # [rad]
    pitch: float = 0.0
    yaw: float = 0.0

    @property
    def position(self) -> Vector:
        """Position in the link's frame [m]."""
        return self.x, self.y, self.z

    @property
    def orientation(self) -> Quaternion:
        """Orientation in the link's frame."""
        return quaternion(self.roll, self.pitch, self.yaw)


class WithLens(Declared):
    """A lens, which looks along its x axis with z up."""

    fov: float = Field(ge=MIN_FOV, le=MAX_FOV)  # vertical [rad]
    width: int = Field(ge=MIN_SIZE, le=MAX_SIZE)  # [pixels]
    height: int = Field(ge=MIN_SIZE, le=MAX_SIZE)

    @property
    def lens(self) -> Lens:
        """The lens."""
        return Lens(self.fov, self.width, self.height)


class LinkSensor(LinkPart):
    """A sensor of a link."""

    rate: float = Field(10.0, gt=0.0, le=MAX_RATE)  # [Hz]


class MountedSensor(Mount, LinkSensor):
    """A sensor at a pose in the frame of a link."""


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


class ImagerDeclaration(WithLens, MountedSensor):
    """A sensor with pixels."""

    @model_validator(mode="after")
    def _few_pixels(self) -> Self:
        if self.width * self.height > MAX_PIXELS:
            raise ValueError(f"{self.name!r} has {self.width} x {self.height} pixels; expected up to {MAX_PIXELS}")
        return self


class DepthCameraDeclaration(ImagerDeclaration, RangingDeclaration):
    """A camera that measures distances along its viewing direction; `rgbd_camera` also has a picture.

    The deviation of a distance z is `noise` + `noise_growth` z^2, as for stereo and structured light [Khoshelham
    and Elberink 2012, Accuracy and resolution of Kinect depth data].
    """

    kind: Literal["depth_camera", "rgbd_camera"]
    noise_growth: NonNegativeFloat = 0.0  # [1/m]
    dropout: Probability = 0.0  # probability that a pixel has no distance


class SegmentationDeclaration(ImagerDeclaration):
    """An ideal detector, which knows the entity of each pixel."""

    kind: Literal["segmentation"]
    min_pixels: PositiveInt = 1  # of an entity with a box


class ForceTorqueDeclaration(LinkSensor):
    """A sensor of the load that a link, and all that hangs on it, exerts on the link before it.

    The joint before the link is fixed.
    """

    kind: Literal["force_torque"]
    force_noise: NonNegativeFloat = 0.0  # standard deviation [N]
    torque_noise: NonNegativeFloat = 0.0  # [N m]


class GpsDeclaration(MountedSensor):
    """A receiver of satellite navigation; the world file needs `geo_origin`.

    The drift is a first-order Gauss-Markov process, independent for east, north and up.
    """

    kind: Literal["gps"]
    noise: NonNegativeFloat = 0.0  # standard deviation of east and north [m]
    height_noise: NonNegativeFloat = 0.0  # of the altitude [m]
    drift: NonNegativeFloat = 0.0  # standard deviation [m]
    drift_time: PositiveFloat = 60.0  # correlation time [s]


SensorDeclaration = Annotated[
    Lidar3dDeclaration
    | SonarDeclaration
    | DepthCameraDeclaration
    | SegmentationDeclaration
    | ForceTorqueDeclaration
    | GpsDeclaration,
    Field(discriminator="kind"),
]
"""Any sensor of the list `sensors`."""
