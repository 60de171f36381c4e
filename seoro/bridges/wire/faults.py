"""Faults of sensors, cameras and motors, and what is measured of them.

A device is a sensor or a camera of a robot (`lidar`, `odometry`, ...), its `motors`, `joints` or `gripper`, or
`robot`, which is all of them. Free cameras are devices of no robot, whose name is empty then. A device has at most
one fault of each kind; another of the kind takes its place.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated, Literal

from pydantic import Field

from seoro.bridges.wire.message import Empty, Message, Verb


class Quantity(StrEnum):
    """What values of sensors are, with their units."""

    LENGTH = "length"  # [m]
    ANGLE = "angle"  # [rad]
    ACCELERATION = "acceleration"  # [m/s^2]
    ANGULAR_RATE = "angular_rate"  # [rad/s]
    BRIGHTNESS = "brightness"  # of red, green and blue, as a share of the brightest


class GaussianNoise(Message):
    """Each value of a quantity has an error, drawn anew every time, of a standard deviation."""

    kind: Literal["gaussian_noise"] = "gaussian_noise"
    deviation: dict[Quantity, float]


class Bias(Message):
    """Each value of a quantity is off by the same."""

    kind: Literal["bias"] = "bias"
    offset: dict[Quantity, float]


class BeamLoss(Message):
    """A share of the beams, drawn anew for each scan, sees nothing: of n beams the whole part of `share` n."""

    kind: Literal["beam_loss"] = "beam_loss"
    share: float


class DeadSector(Message):
    """Beams from one bearing to another see nothing; bearings grow to the left, with zero straight ahead."""

    kind: Literal["dead_sector"] = "dead_sector"
    start: float
    end: float


class DeadBeams(Message):
    """Beams see nothing, by their indices in the scan."""

    kind: Literal["dead_beams"] = "dead_beams"
    beams: tuple[int, ...]


class DeadPixels(Message):
    """A share of the pixels, always the same ones, is black: of n pixels the whole part of `share` n."""

    kind: Literal["dead_pixels"] = "dead_pixels"
    share: float


class DeadArea(Message):
    """A rectangle is black, in shares of the width from the left and of the height from the top."""

    kind: Literal["dead_area"] = "dead_area"
    left: float
    top: float
    right: float
    bottom: float


class MessageLoss(Message):
    """Each sample or command, or picture that is asked for, is lost with a probability."""

    kind: Literal["message_loss"] = "message_loss"
    probability: float


class Freeze(Message):
    """Samples, commands or pictures go on to come, and all have the values of the first."""

    kind: Literal["freeze"] = "freeze"


class Delay(Message):
    """Samples and commands come later by a time [s]; pictures are as old as that."""

    kind: Literal["delay"] = "delay"
    time: float


class WheelSlip(Message):
    """Wheels turn without moving the robot by a share of what they turn: 0 is grip, 1 is none."""

    kind: Literal["wheel_slip"] = "wheel_slip"
    left: float
    right: float


class PowerLoss(Message):
    """A sensor sends nothing, a camera gives no pictures, motors have no torque."""

    kind: Literal["power_loss"] = "power_loss"


SensorFault = GaussianNoise | Bias | BeamLoss | DeadSector | DeadBeams | MessageLoss | Freeze | Delay | PowerLoss
CameraFault = GaussianNoise | Bias | DeadPixels | DeadArea | MessageLoss | Freeze | Delay | PowerLoss
Fault = SensorFault | CameraFault | WheelSlip


class InjectFault(Message):
    """Inject a fault, and measure whether it takes effect; without a `robot`, the device is a free camera.

    The end of the measurement is reported as the `Occurrence` with this `id`: succeeded, with what was measured;
    aborted, and the fault is cleared, when it has not been found to take effect within `limit` [s].
    """

    id: str
    robot: str
    device: str
    fault: Annotated[Fault, Field(discriminator="kind")]
    limit: float


class ClearFaults(Message):
    """Clear the faults of a device, or of all, of one kind, or of all; their measurements end as canceled.

    Without a `robot`, devices are the free cameras.
    """

    robot: str
    device: str = ""
    kind: str = ""


INJECT_FAULT = Verb("inject_fault", InjectFault, Empty)
CLEAR_FAULTS = Verb("clear_faults", ClearFaults, Empty)
