"""Arms with grippers: motions, gripping, joints."""

from __future__ import annotations

from enum import IntEnum

from seoro.bridges.wire.limits import MEBIBYTE, Limits
from seoro.bridges.wire.message import Empty, Message, Query, TrackedRequest, Verb
from seoro.bridges.wire.simulator import RobotName
from seoro.robotics.geometry import Pose3D


class ArmResult(IntEnum):
    """Result codes of motions beyond the common ones."""

    UNREACHABLE = 101
    IN_COLLISION = 102
    OUT_OF_LIMITS = 103


class ArmMotion(TrackedRequest):
    """Common fields of motions; the end is reported as the `Occurrence` with this `id`.

    An arm executes one motion at a time. A goal out of reach, or a collision except with the entities in
    `may_touch`, is refused before the arm moves. With `plan_only`, the arm does not move. A motion aborts when an
    obstacle stops the arm, or when its joints end more than `tolerance` [rad] from their targets. With `replan`,
    robots that sense obstacles may plan another path first.
    """

    robot: str
    max_velocity_scaling_factor: float = 1.0  # share of the maximum joint speed
    tolerance: float = 1e-3
    may_touch: tuple[str, ...] = ()
    plan_only: bool = False
    replan: bool = False


class FollowJointTrajectory(ArmMotion):
    """Move the joints of an arm through points, each with a position for each joint [rad], [m].

    Positions are in the order of `joint_names`; if it is empty, of `get_joint_states`. Joints without a name keep
    the position of their last goal.
    """

    points: tuple[tuple[float, ...], ...]
    joint_names: tuple[str, ...] = ()


class TakePosture(ArmMotion):
    """Move the joints of an arm to a posture of its declaration.

    Joints that the posture does not name keep the position of their last goal.
    """

    posture: str


class MoveToPose(ArmMotion):
    """Move the tool of an arm to a pose, in a straight line if `straight`.

    `frame` is `map`, or `base_link` for the base of the arm.
    """

    pose: Pose3D
    frame: str = "map"
    straight: bool = False


class GripperCommand(TrackedRequest):
    """Move a gripper to an opening [m] with a maximum force [N]; None for the usual force.

    It succeeds when the opening is reached within `tolerance` [m], or when closing fingers are stopped.
    """

    robot: str
    opening: float
    force: float | None = None
    max_velocity_scaling_factor: float = 1.0
    tolerance: float = 1e-3


class HoldEntity(TrackedRequest):
    """Report when a gripper has held an entity for a duration [s]; aborted at once when it loses the entity.

    An empty `entity` selects the present one.
    """

    robot: str
    entity: str = ""
    duration: float = 0.0


class JointStates(Message):
    """Joints of an arm and its gripper: positions [rad, m], velocities [rad/s, m/s], efforts [N m, N]."""

    names: tuple[str, ...]
    positions: tuple[float, ...]
    velocities: tuple[float, ...]
    efforts: tuple[float, ...]


class ArmState(Message):
    """State of an arm: pose of its tool, opening of its gripper [m], held entity, remaining time of motion [s]."""

    tool: Pose3D
    opening: float
    held: str
    remaining: float


class WatchJoint(TrackedRequest):
    """Report when a joint is within `tolerance` of `position` [rad, m], or has passed it."""

    robot: str
    joint: str
    position: float
    tolerance: float


TRAJECTORY = Limits(MEBIBYTE, 50_000)  # 1000 points of an arm with 40 joints

FOLLOW_JOINT_TRAJECTORY = Verb("follow_joint_trajectory", FollowJointTrajectory, Empty, TRAJECTORY)
TAKE_POSTURE = Verb("take_posture", TakePosture, Empty)
MOVE_TO_POSE = Verb("move_to_pose", MoveToPose, Empty)
GRIPPER_COMMAND = Verb("gripper_command", GripperCommand, Empty)
HOLD_ENTITY = Verb("hold_entity", HoldEntity, Empty)
GET_JOINT_STATES = Query("get_joint_states", RobotName, JointStates)
GET_ARM_STATE = Query("get_arm_state", RobotName, ArmState)
WATCH_JOINT = Verb("watch_joint", WatchJoint, Empty)
