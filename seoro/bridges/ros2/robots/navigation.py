"""Navigation of a robot by Nav2."""

from __future__ import annotations

import time
from collections.abc import Callable

from seoro.bridges import wire
from seoro.bridges.ros2 import geometry
from seoro.bridges.ros2.clients.members import Members
from seoro.bridges.ros2.robots.link import RobotLink
from seoro.bridges.ros2.robots.profile import Base
from seoro.bridges.ros2.robots.pursuit import ActionGoal, pursue
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused, check_finite

MAX_POSES = 100
NAVIGATE_TO_POSE, NAVIGATE_THROUGH_POSES, FOLLOW_WAYPOINTS = (
    f"nav2_msgs/action/{name}" for name in ("NavigateToPose", "NavigateThroughPoses", "FollowWaypoints")
)


async def navigate(link: RobotLink, base: Base, request: wire.NavigateThroughPoses) -> None:
    """Drive a robot through poses."""
    if not 1 <= len(request.poses) <= MAX_POSES:
        raise RequestRefused(Result.OPERATION_FAILED, f"expected 1 to {MAX_POSES} poses, got {len(request.poses)}")
    for pose in request.poses:
        check_pose(pose)
    await pursue(link, request.id, _goal(link, base, request))


def _goal(link: RobotLink, base: Base, request: wire.NavigateThroughPoses) -> ActionGoal:
    header = geometry.header(base.map_frame, 0.0)
    poses = [{"header": header, "pose": geometry.pose_message(pose)} for pose in request.poses]
    report = _feedback_reporter(link, request.feedback_period, len(poses))
    goal = {"poses": poses}
    if request.stop_at_each:
        return ActionGoal(base.follow_waypoints, FOLLOW_WAYPOINTS, goal, report)
    if len(poses) == 1:
        return ActionGoal(base.navigate_to_pose, NAVIGATE_TO_POSE, {"pose": poses[0]}, report)
    return ActionGoal(base.navigate_through_poses, NAVIGATE_THROUGH_POSES, goal, report)


def _feedback_reporter(link: RobotLink, period: float, poses: int) -> Callable[[Members], None]:
    """Return a callback that reports feedback at most once in a period [s]."""
    due = 0.0

    def report(feedback: Members) -> None:
        nonlocal due
        now = time.monotonic()
        if period > 0.0 and now >= due:
            due = now + period
            link.events.add(feedback=_converted(link.name, link.events.now, feedback, poses))

    return report


def check_pose(pose: wire.Pose3D) -> None:
    """Refuse a pose that is not finite.

    Raises:
        RequestRefused: A number is NaN or infinite.
    """
    position, angles = pose.position, pose.orientation
    check_finite("pose", position.x, position.y, position.z, angles.roll, angles.pitch, angles.yaw)


def _converted(robot: str, now: float, feedback: Members, poses: int) -> wire.NavigationFeedback:
    """Convert the feedback of a Nav2 action; that of following waypoints has an index only."""

    def seconds(name: str) -> float:
        return geometry.seconds(getattr(feedback.message, name)) if name in feedback else 0.0

    left = feedback.get("number_of_poses_remaining")
    return wire.NavigationFeedback(
        robot=robot,
        time=now,
        navigation_time=seconds("navigation_time"),
        distance_remaining=float(feedback.get("distance_remaining", 0.0)),
        estimated_time_remaining=seconds("estimated_time_remaining"),
        number_of_recoveries=int(feedback.get("number_of_recoveries", 0)),
        number_of_poses_remaining=poses - int(feedback.get("current_waypoint", 0)) if left is None else int(left),
    )
