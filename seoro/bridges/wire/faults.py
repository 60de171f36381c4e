"""Injection of faults into sensors, cameras and motors.

A device is a sensor or a camera of a robot (`lidar`, `odometry`, ...), its `motors`, `joints` or `gripper`, or
`robot`, which means all of them. Free cameras are devices without a robot; its name is empty then.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from seoro.bridges.wire.message import Empty, Message, TrackedRequest, Verb
from seoro.robotics.faults import Fault


class InjectFault(TrackedRequest):
    """Inject a fault, and measure whether it takes effect; without a `robot`, the device is a free camera.

    The end of the measurement is reported as the `Occurrence` with this `id`. It succeeds with the measured value.
    If no effect is found within `limit` [s], it aborts and the fault is cleared.
    """

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
