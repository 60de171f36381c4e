"""Robots that are driven by velocities, without knowing where they are."""

from __future__ import annotations

from seoro.bridges.wire.geometry import Twist
from seoro.bridges.wire.message import Empty, Message, Verb


class Drive(Message):
    """Drive with a velocity for a duration [s], and stop; the end is reported as the `Occurrence` with this `id`.

    `linear` [m/s] is ahead, `angular` [rad/s] to the left. `cancel_goal` ends it before its time.
    """

    id: str
    robot: str
    linear: float
    angular: float
    duration: float


class CmdVel(Message):
    """A single command of velocity, as on a ROS topic `cmd_vel`: obeyed until the next, but for 0.5 s at most.

    An empty `robot` is the first one that drives.
    """

    robot: str
    twist: Twist


DRIVE = Verb("drive", Drive, Empty)
CMD_VEL = Verb("cmd_vel", CmdVel, Empty)
