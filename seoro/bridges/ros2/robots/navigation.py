"""Driving to poses by the navigation on the robot (Nav2)."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from seoro.bridges import wire
from seoro.bridges.ros2 import geometry
from seoro.bridges.ros2.clients.members import Members
from seoro.bridges.ros2.robots.link import Link
from seoro.bridges.ros2.robots.profile import Base
from seoro.bridges.ros2.robots.pursuit import ActionGoal, pursue
from seoro.bridges.serving.happenings import HappeningLog
from seoro.bridges.serving.work import Aborted, Work
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused, check_finite

MAX_POSES = 100


class Navigation:
    """The navigation of a robot.

    Args:
        link: To the robot.
        base: What it calls things.
        robot: Its name.
        work: Where goals are told of.
        happenings: Where it is told how far it is.
    """

    def __init__(self, link: Link, base: Base, robot: str, work: Work, happenings: HappeningLog) -> None:
        self._link = link
        self._base = base
        self._robot = robot
        self._work = work
        self._happenings = happenings

    async def navigate(self, request: wire.NavigateThroughPoses) -> wire.Empty:
        """Drive through poses."""
        if not 1 <= len(request.poses) <= MAX_POSES:
            raise RequestRefused(
                Result.OPERATION_FAILED, f"{len(request.poses)} poses were given: give 1 to {MAX_POSES}"
            )
        for pose in request.poses:
            place, turned = pose.position, pose.orientation
            check_finite("pose", place.x, place.y, place.z, turned.roll, turned.pitch, turned.yaw)
        await pursue(self._link, self._work, request.id, self._robot, self._goal(request))
        return wire.Empty()

    def _goal(self, request: wire.NavigateThroughPoses) -> ActionGoal:
        base, poses = self._base, [self._stamped(pose) for pose in request.poses]
        told = self._teller(request.feedback_period, len(poses))
        if request.stop_at_each:
            return ActionGoal(
                base.follow_waypoints,
                "nav2_msgs/action/FollowWaypoints",
                {"poses": poses},
                told,
                judge=_all_reached,
            )
        if len(poses) == 1:
            return ActionGoal(base.navigate_to_pose, "nav2_msgs/action/NavigateToPose", {"pose": poses[0]}, told)
        return ActionGoal(
            base.navigate_through_poses, "nav2_msgs/action/NavigateThroughPoses", {"poses": poses}, told
        )

    def _stamped(self, pose: wire.Pose) -> Mapping[str, Any]:
        return {"header": geometry.header(self._base.map_frame, 0.0), "pose": geometry.pose_message(pose)}

    def _teller(self, period: float, poses: int) -> Callable[[Members], None]:
        """What tells how far the robot is, not more often than asked for."""
        due = 0.0

        def tell(feedback: Members) -> None:
            nonlocal due
            now = time.monotonic()
            if period > 0.0 and now >= due:
                due = now + period
                told = _feedback(self._robot, self._happenings.now, feedback, poses)
                self._happenings.tell(feedback=told)

        return tell


def _feedback(robot: str, now: float, told: Members, poses: int) -> wire.NavigationFeedback:
    """What an action of Nav2 tells; following waypoints, it only tells which one."""
    times = {
        name: geometry.seconds(getattr(told.message, name)) if name in told else 0.0
        for name in ("navigation_time", "estimated_time_remaining")
    }
    left = told.get("number_of_poses_remaining")
    return wire.NavigationFeedback(
        robot=robot,
        time=now,
        navigation_time=times["navigation_time"],
        distance_remaining=float(told.get("distance_remaining", 0.0)),
        estimated_time_remaining=times["estimated_time_remaining"],
        number_of_recoveries=int(told.get("number_of_recoveries", 0)),
        number_of_poses_remaining=poses - int(told.get("current_waypoint", 0)) if left is None else int(left),
    )


def _all_reached(result: Mapping[str, Any]) -> str:
    missed: Sequence[Any] = result.get("missed_waypoints", ())
    if len(missed):
        # A number in Humble, a message with the number in later distributions.
        numbers = [each.get("index", 0) if isinstance(each, Mapping) else each for each in missed]
        raise Aborted(f"waypoints were missed: {', '.join(str(int(number) + 1) for number in numbers)}")
    return ""
