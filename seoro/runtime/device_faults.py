"""Faults of sensors, cameras and motors: what `capabilities.Faults` is asked for. SI units and radians."""

from __future__ import annotations

from collections.abc import Sequence

from seoro.lang.frozen import Value


class Amounts(Value):
    """Amounts of what values of sensors are; zero for what is not concerned."""

    length: float = 0.0  # [m]
    angle: float = 0.0  # [rad]
    acceleration: float = 0.0  # [m/s^2]
    angular_rate: float = 0.0  # [rad/s]
    brightness: float = 0.0  # of pixels, as a share of the brightest


class GaussianNoise(Value):
    """Values have errors of a standard deviation."""

    deviation: Amounts


class Bias(Value):
    """Values are off by an amount."""

    offset: Amounts


class BeamLoss(Value):
    """A share of the beams sees nothing, others in each scan."""

    share: float


class DeadSector(Value):
    """Beams from one bearing to another see nothing; bearings grow to the left, with zero straight ahead [rad]."""

    start: float
    end: float


class DeadBeams(Value):
    """Beams see nothing, by their indices in the scan."""

    beams: Sequence[int]


class DeadPixels(Value):
    """A share of the pixels is black, always the same ones."""

    share: float


class DeadArea(Value):
    """A rectangle is black, in shares of the width from the left and of the height from the top."""

    left: float
    top: float
    right: float
    bottom: float


class MessageLoss(Value):
    """Each sample is lost with a probability, or each picture that is asked for."""

    probability: float


class Freeze(Value):
    """Samples or pictures go on to come with the values of the first."""


class Delay(Value):
    """Samples come late by a time [s]; pictures are as old as that."""

    time: float


class WheelSlip(Value):
    """Wheels turn without moving the robot, by a share of what they turn."""

    left: float
    right: float


class PowerLoss(Value):
    """A sensor sends nothing, a camera gives no pictures, motors have no torque."""


Fault = (
    GaussianNoise
    | Bias
    | BeamLoss
    | DeadSector
    | DeadBeams
    | DeadPixels
    | DeadArea
    | MessageLoss
    | Freeze
    | Delay
    | WheelSlip
    | PowerLoss
)
