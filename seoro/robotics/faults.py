"""Faults of sensors, cameras and motors. Units are SI, angles radians.

A device has at most one fault of each kind; a new fault replaces another of its kind.
"""

from __future__ import annotations

from dataclasses import field
from enum import StrEnum
from typing import Literal, TypeAlias

from seoro.deferred import dataclass
from seoro.robotics.geometry import Record


class Quantity(StrEnum):
    """Quantities that sensors measure, with their units."""

    LENGTH = "length"  # [m]
    ANGLE = "angle"  # [rad]
    ACCELERATION = "acceleration"  # [m/s^2]
    ANGULAR_RATE = "angular_rate"  # [rad/s]
    FORCE = "force"  # [N]
    TORQUE = "torque"  # [N m]
    BRIGHTNESS = "brightness"  # of red, green and blue, as a share of the brightest


Amounts: TypeAlias = dict[Quantity, float]
"""Amounts by quantity; quantities that are not contained are unaffected."""


@dataclass(frozen=True)
class GaussianNoise(Record):
    """Normally distributed errors of the values, by their standard deviation; drawn anew for each value."""

    kind: Literal["gaussian_noise"] = field(default="gaussian_noise", kw_only=True)
    deviation: Amounts


@dataclass(frozen=True)
class Bias(Record):
    """Constant errors of the values."""

    kind: Literal["bias"] = field(default="bias", kw_only=True)
    offset: Amounts


@dataclass(frozen=True)
class BeamLoss(Record):
    """Loss of a share of the beams, redrawn for each scan; of n beams, the whole part of `share` n."""

    kind: Literal["beam_loss"] = field(default="beam_loss", kw_only=True)
    share: float


@dataclass(frozen=True)
class DeadSector(Record):
    """Loss of all beams between two bearings [rad]; 0 is straight ahead, bearings grow to the left."""

    kind: Literal["dead_sector"] = field(default="dead_sector", kw_only=True)
    start: float
    end: float


@dataclass(frozen=True)
class DeadBeams(Record):
    """Loss of beams, by their indices in the scan."""

    kind: Literal["dead_beams"] = field(default="dead_beams", kw_only=True)
    beams: tuple[int, ...]


@dataclass(frozen=True)
class DeadPixels(Record):
    """Black pixels, always the same ones; of n pixels, the whole part of `share` n."""

    kind: Literal["dead_pixels"] = field(default="dead_pixels", kw_only=True)
    share: float


@dataclass(frozen=True)
class DeadArea(Record):
    """Black rectangle, in shares of the width from the left and of the height from the top."""

    kind: Literal["dead_area"] = field(default="dead_area", kw_only=True)
    left: float
    top: float
    right: float
    bottom: float


@dataclass(frozen=True)
class MessageLoss(Record):
    """Loss of samples, commands or requested pictures, each with a probability."""

    kind: Literal["message_loss"] = field(default="message_loss", kw_only=True)
    probability: float


@dataclass(frozen=True)
class Freeze(Record):
    """Values of samples, commands or pictures, frozen at those of the first."""

    kind: Literal["freeze"] = field(default="freeze", kw_only=True)


@dataclass(frozen=True)
class Delay(Record):
    """Late samples and commands, or old pictures, by a time [s]."""

    kind: Literal["delay"] = field(default="delay", kw_only=True)
    time: float


@dataclass(frozen=True)
class WheelSlip(Record):
    """Slip of the wheels, as a share of their rotation: 0 is full grip, 1 is full slip."""

    kind: Literal["wheel_slip"] = field(default="wheel_slip", kw_only=True)
    left: float
    right: float


@dataclass(frozen=True)
class PowerLoss(Record):
    """Power failure: no samples, no pictures, no motor torque."""

    kind: Literal["power_loss"] = field(default="power_loss", kw_only=True)


SensorFault = GaussianNoise | Bias | BeamLoss | DeadSector | DeadBeams | MessageLoss | Freeze | Delay | PowerLoss
CameraFault = GaussianNoise | Bias | DeadPixels | DeadArea | MessageLoss | Freeze | Delay | PowerLoss
Fault = SensorFault | CameraFault | WheelSlip
