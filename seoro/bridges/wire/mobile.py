"""Robots that drive: localisation, goals, watches on where they are."""

from __future__ import annotations

from seoro.bridges.wire.geometry import Pose, Vector3
from seoro.bridges.wire.message import Empty, Message, Verb


class SetInitialPose(Message):
    """Tell the localisation of a robot where it is."""

    robot: str
    pose: Pose


class NavigateThroughPoses(Message):
    """Drive a robot through poses, in order; one at a time, a new goal while one is active is refused.

    `stop_at_each` makes every pose a goal of its own, as `follow_waypoints` of Nav2 does. The end is
    reported as the `Occurrence` with this `id`. With a `feedback_period` above 0 [s], grants of time end that
    often with how far the robot is.
    """

    id: str
    robot: str
    poses: tuple[Pose, ...]
    stop_at_each: bool = False
    feedback_period: float = 0.0


class StopRobot(Message):
    """Cancel whatever a robot does and command zero velocity."""

    robot: str


class WatchProximity(Message):
    """Report when `frame` is within `threshold` [m] of `point`, in the plane of `parent_frame`.

    Frames that each robot has, such as `base_link`, are those of `robot`; without one, of the first that drives.
    """

    id: str
    frame: str
    parent_frame: str
    point: Vector3
    threshold: float
    robot: str = ""


class WatchDistance(Message):
    """Report when the odometry of a robot has counted `distance` [m] more than now."""

    id: str
    robot: str
    distance: float


class RelativePose(Message):
    """A point `distance` [m] ahead of `frame`, in `parent_frame`."""

    frame: str
    parent_frame: str
    distance: float


SET_INITIAL_POSE = Verb("set_initial_pose", SetInitialPose, Empty)
NAVIGATE_THROUGH_POSES = Verb("navigate_through_poses", NavigateThroughPoses, Empty)
STOP_ROBOT = Verb("stop_robot", StopRobot, Empty)
WATCH_PROXIMITY = Verb("watch_proximity", WatchProximity, Empty)
WATCH_DISTANCE = Verb("watch_distance", WatchDistance, Empty)
GET_RELATIVE_POSE = Verb("get_relative_pose", RelativePose, Pose)
