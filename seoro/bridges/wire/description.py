"""What robots are made of, for those who show them to others."""

from __future__ import annotations

from seoro.bridges.wire.arms import RobotName
from seoro.bridges.wire.message import Message, Verb


class LidarDescription(Message):
    """A planar lidar: the link that it is on, turned by `yaw` [rad] from the base, and what it can measure [m]."""

    link: str
    yaw: float
    range_min: float
    range_max: float
    rate: float  # [Hz]


class ArmDescription(Message):
    """An arm: its joints in order from the base, the fingers of its gripper, and how far these open [m]."""

    joints: tuple[str, ...]
    fingers: tuple[str, str]
    stroke: float


class RobotDescription(Message):
    """A robot: the text of its URDF, the link that is its base, the names of its sensors, and its parts.

    The speeds are the highest that it can be driven with [m/s, rad/s]; zero for one that does not drive.
    """

    urdf: str
    base_link: str
    sensors: tuple[str, ...]
    lidar: LidarDescription | None = None
    arm: ArmDescription | None = None
    max_speed: float = 0.0
    max_turn_rate: float = 0.0
    has_battery: bool = False


GET_ROBOT_DESCRIPTION = Verb("get_robot_description", RobotName, RobotDescription)
