"""Arms with grippers: motions, gripping, joints."""

from __future__ import annotations

from enum import IntEnum

from seoro.bridges.wire.geometry import Pose
from seoro.bridges.wire.limits import MEBIBYTE, Limits
from seoro.bridges.wire.message import Empty, Message, Verb


class ArmResult(IntEnum):
    """Result codes of motions beyond the common ones."""

    UNREACHABLE = 101
    IN_COLLISION = 102
    OUT_OF_LIMITS = 103


class ArmMotion(Message):
    """What all motions have in common; the end is reported as the `Occurrence` with this `id`.

    An arm makes one motion at a time. What is out of reach, or would collide with anything but the entities in
    `may_touch`, is refused before the arm moves; with `plan_only` it does not move at all. A motion aborts when
    something stops the arm, or when its joints do not come within `tolerance` [rad] of where they should be; with
    `replan`, robots that see what comes into their way may look for another first.
    """

    id: str
    robot: str
    max_velocity_scaling_factor: float = 1.0  # part of the speed that the joints can have
    tolerance: float = 1e-3
    may_touch: tuple[str, ...] = ()
    plan_only: bool = False
    replan: bool = False


class FollowJointTrajectory(ArmMotion):
    """Move the joints of an arm through points, each a position for each joint [rad].

    They are in the order of `joint_names`, or without these in that of `get_joint_states`.
    """

    points: tuple[tuple[float, ...], ...]
    joint_names: tuple[str, ...] = ()


class MoveToPose(ArmMotion):
    """Move the tool of an arm to a pose, in a straight line if `straight`.

    `frame` is `map`, or `base_link` for the base of the arm.
    """

    pose: Pose
    frame: str = "map"
    straight: bool = False


class GripperCommand(Message):
    """Open or close a gripper to an opening [m], its fingers pressing with a force [N] at most, or its usual one.

    It has succeeded when the opening is reached within `tolerance` [m], or when closing fingers are stopped.
    """

    id: str
    robot: str
    opening: float
    force: float | None = None
    max_velocity_scaling_factor: float = 1.0
    tolerance: float = 1e-3


class HoldEntity(Message):
    """Report when a gripper has held an entity for a duration [s], or at once, as aborted, when it loses that.

    An empty `entity` is what it holds now.
    """

    id: str
    robot: str
    entity: str = ""
    duration: float = 0.0


class RobotName(Message):
    """A robot by name."""

    robot: str


class JointStates(Message):
    """The joints of an arm and of its gripper: positions [rad, m], velocities [rad/s, m/s], efforts [N m, N]."""

    names: tuple[str, ...]
    positions: tuple[float, ...]
    velocities: tuple[float, ...]
    efforts: tuple[float, ...]


class ArmState(Message):
    """An arm: the pose of its tool, opening of its gripper [m], what it holds, and how long it moves on [s]."""

    tool: Pose
    opening: float
    held: str
    remaining: float


class WatchJoint(Message):
    """Report when a joint is within `tolerance` of `position` [rad, m], or has passed it."""

    id: str
    robot: str
    joint: str
    position: float
    tolerance: float


TRAJECTORY = Limits(MEBIBYTE, 50_000)  # 1000 points of an arm with 40 joints

FOLLOW_JOINT_TRAJECTORY = Verb("follow_joint_trajectory", FollowJointTrajectory, Empty, TRAJECTORY)
MOVE_TO_POSE = Verb("move_to_pose", MoveToPose, Empty)
GRIPPER_COMMAND = Verb("gripper_command", GripperCommand, Empty)
HOLD_ENTITY = Verb("hold_entity", HoldEntity, Empty)
GET_JOINT_STATES = Verb("get_joint_states", RobotName, JointStates)
GET_ARM_STATE = Verb("get_arm_state", RobotName, ArmState)
WATCH_JOINT = Verb("watch_joint", WatchJoint, Empty)
