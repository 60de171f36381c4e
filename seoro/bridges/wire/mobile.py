"""Robots that drive: localisation, goals, velocities, feedback, and watches of their position."""

from __future__ import annotations

from typing import Literal

from seoro.bridges.wire.geometry import Twist
from seoro.bridges.wire.message import Empty, Message, Query, TrackedRequest, Verb
from seoro.bridges.wire.simulator import RobotName
from seoro.robotics.geometry import Orientation3D, Pose3D, Position3D


class SetInitialPose(Message):
    """Set the pose of a robot in its localisation."""

    robot: str
    pose: Pose3D


class NavigateThroughPoses(TrackedRequest):
    """Drive a robot through poses, in order; refused while another goal is active.

    `stop_at_each` makes every pose a goal of its own, as `follow_waypoints` of Nav2 does. The end is reported as
    the `Occurrence` with this `id`. With a `feedback_period` above 0 [s], grants of time end after each period
    with the progress of the robot.
    """

    robot: str
    poses: tuple[Pose3D, ...]
    stop_at_each: bool = False
    feedback_period: float = 0.0


class StopRobot(Message):
    """Cancel the goals of a robot and command zero velocity."""

    robot: str


class WatchProximity(TrackedRequest):
    """Report when `frame` is within `threshold` [m] of `point`, in the plane of `parent_frame`.

    Frames of every robot, such as `base_link`, are those of `robot`; if it is empty, of the first robot that
    drives.
    """

    frame: str
    parent_frame: str
    point: Position3D
    threshold: float
    robot: str = ""


class WatchDistance(TrackedRequest):
    """Report when the odometry of a robot has increased by `distance` [m]."""

    robot: str
    distance: float


class FramePose(Message):
    """Pose of a frame in its parent frame."""

    position: Position3D
    orientation: Orientation3D


class RelativePose(Message):
    """Request a point `distance` [m] ahead of `frame`, in `parent_frame`."""

    frame: str
    parent_frame: str
    distance: float


class NavigationFeedback(Message):
    """Progress of a robot to its goal; without a goal, the request is refused as INCORRECT_STATE.

    Attributes:
        robot: Name of the robot.
        time: Time of the simulator's clock [s].
        navigation_time: Time since the goal was accepted [s].
        distance_remaining: Distance along the plan to the next pose, then straight from pose to pose [m].
        estimated_time_remaining: Remaining time at the mean speed up to now [s].
        number_of_recoveries: Number of recoveries for this goal.
        number_of_poses_remaining: Number of remaining poses, including the next.
    """

    robot: str
    time: float
    navigation_time: float
    distance_remaining: float
    estimated_time_remaining: float
    number_of_recoveries: int
    number_of_poses_remaining: int


class WatchLocalization(TrackedRequest):
    """Report when the localisation of a robot has a pose, which may be at once."""

    robot: str


class Localization(Message):
    """Estimate of the localisation of a robot, and its true error.

    Attributes:
        pose: Estimated pose of the robot; None while it is unknown.
        covariance: Covariance of x, y and yaw, row by row [m^2, m rad, rad^2]; None without a pose.
        particles: Number of particles.
        error: Distance between this pose and the true one [m]; None without a pose.
        unlocalized: Without an estimate, pose by the frames or the odometry of the robot, for traces; None if it
            is unknown, too.
        unlocalized_frame: Frame of `unlocalized`: `odom` is that of the odometry.
    """

    pose: Pose3D | None
    covariance: tuple[float, ...] | None
    particles: int
    error: float | None
    unlocalized: Pose3D | None = None
    unlocalized_frame: Literal["map", "odom"] = "map"


class Drive(TrackedRequest):
    """Drive with a velocity for a duration [s], then stop; the end is reported as the `Occurrence` with this `id`.

    `linear` [m/s] is ahead, `angular` [rad/s] and `lateral` [m/s] are to the left. `cancel_goal` ends it early.
    """

    robot: str
    linear: float
    angular: float
    duration: float
    lateral: float = 0.0


class FollowPath(TrackedRequest):
    """Drive along straight lines between points by the true pose of the robot; obstacles are not avoided.

    It needs neither a map nor a localisation. The end is reported as the `Occurrence` with this `id`. The goal is
    aborted after a time without progress, and refused while another one is active.

    Attributes:
        robot: Name of a robot that drives.
        points: Points of the path; z is ignored.
        speed: [m/s]; 0 for the robot's maximum.
        repeat: Whether to start again at the first point, without an end.
    """

    robot: str
    points: tuple[Position3D, ...]
    speed: float = 0.0
    repeat: bool = False


class CmdVel(Message):
    """Velocity command, as on a ROS topic `cmd_vel`: valid until the next, for at most 0.5 s.

    An empty `robot` selects the first robot that drives.
    """

    robot: str
    twist: Twist


SET_INITIAL_POSE = Verb("set_initial_pose", SetInitialPose, Empty)
NAVIGATE_THROUGH_POSES = Verb("navigate_through_poses", NavigateThroughPoses, Empty)
STOP_ROBOT = Verb("stop_robot", StopRobot, Empty)
WATCH_PROXIMITY = Verb("watch_proximity", WatchProximity, Empty)
WATCH_DISTANCE = Verb("watch_distance", WatchDistance, Empty)
GET_RELATIVE_POSE = Query("get_relative_pose", RelativePose, FramePose)
GET_NAVIGATION_FEEDBACK = Query("get_navigation_feedback", RobotName, NavigationFeedback)
REINITIALIZE_GLOBAL_LOCALIZATION = Verb("reinitialize_global_localization", RobotName, Empty)
WATCH_LOCALIZATION = Verb("watch_localization", WatchLocalization, Empty)
GET_LOCALIZATION = Query("get_localization", RobotName, Localization)
DRIVE = Verb("drive", Drive, Empty)
FOLLOW_PATH = Verb("follow_path", FollowPath, Empty)
CMD_VEL = Verb("cmd_vel", CmdVel, Empty)
