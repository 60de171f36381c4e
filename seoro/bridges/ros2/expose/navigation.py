"""The navigation of a robot as the actions of Nav2, executed by the navigation of the simulator node.

As in Nav2, a new goal replaces an earlier goal of the same action, which is aborted. It is rejected while another
action of the robot has a goal.
"""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from functools import partial
from typing import Any

from seoro.bridges import wire
from seoro.bridges.ros2 import geometry
from seoro.bridges.ros2.action_server import GoalEnd, GoalHandle, Status, serving_action
from seoro.bridges.ros2.expose.entities import check_frame, read_pose
from seoro.bridges.ros2.expose.goal_queue import GoalQueue
from seoro.bridges.ros2.expose.messages import MAP
from seoro.bridges.ros2.expose.node import ExposedNode, OnFeedback
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.wire import Outcome, Result
from seoro.errors import BackendRefused

TO_POSE, THROUGH_POSES, WAYPOINTS = "navigate_to_pose", "navigate_through_poses", "follow_waypoints"
TYPES = {TO_POSE: "NavigateToPose", THROUGH_POSES: "NavigateThroughPoses", WAYPOINTS: "FollowWaypoints"}
PERIOD = 0.5  # [s] of the simulator's clock between two messages of feedback
FAILED = 9000  # error code of Nav2 for other errors

STATUS = {
    Outcome.SUCCEEDED: Status.SUCCEEDED,
    Outcome.CANCELED: Status.CANCELED,
    Outcome.ABORTED: Status.ABORTED,
}


class RobotNavigation:
    """Execution of the navigation goals of a robot.

    Args:
        node: Simulator node of the robot.
        robot: Name of the robot.
        estimate: Returns the estimated pose of the robot, if known.
    """

    def __init__(self, node: ExposedNode, robot: str, estimate: Callable[[], wire.Pose3D | None]) -> None:
        self._node = node
        self._robot = robot
        self._estimate = estimate
        self._queues = {action: GoalQueue() for action in TYPES}

    def accept(self, action: str, goal: GoalHandle) -> bool:
        """Accept a goal of an action, unless another action has one."""
        if any(queue.has_goals for other, queue in self._queues.items() if other != action):
            return False
        self._queues[action].reserve(goal)  # at once, before the next goal is accepted
        return True

    async def execute(self, action: str, goal: GoalHandle) -> GoalEnd:
        """Execute a goal of an action."""
        replaced = GoalEnd(Status.ABORTED, _failed("replaced by another goal"))
        async with self._queues[action].turn(goal, replaced):
            if action == WAYPOINTS:
                return await self._follow(goal)
            poses = [goal.goal.pose] if action == TO_POSE else goal.goal.poses
            return await self._drive(poses, self._feedback_publisher(action, goal))

    def _feedback_publisher(self, action: str, goal: GoalHandle) -> OnFeedback:
        def publish(feedback: wire.NavigationFeedback) -> None:
            fields = {
                "navigation_time": geometry.stamp(feedback.navigation_time),
                "estimated_time_remaining": geometry.stamp(feedback.estimated_time_remaining),
                "number_of_recoveries": feedback.number_of_recoveries,
                "distance_remaining": feedback.distance_remaining,
            }
            if action == THROUGH_POSES:
                fields["number_of_poses_remaining"] = feedback.number_of_poses_remaining
            if (pose := self._estimate()) is not None:
                fields["current_pose"] = {
                    "header": geometry.header(MAP, feedback.time),
                    "pose": geometry.pose_message(pose),
                }
            goal.publish_feedback(fields)

        return publish

    async def _drive(self, stamped: Sequence[Any], on_feedback: OnFeedback) -> GoalEnd:
        """Drive through poses, and stop at the last one."""
        try:
            poses, identifier = tuple(_pose(each) for each in stamped), self._node.new_id()
            request = wire.NavigateThroughPoses(
                id=identifier, robot=self._robot, poses=poses, feedback_period=PERIOD
            )
            async with self._node.receiving_feedback(self._robot, on_feedback):
                ended = await self._node.pursue(wire.NAVIGATE_THROUGH_POSES, request)
        except BackendRefused as error:
            return GoalEnd(Status.ABORTED, _failed(str(error)))
        return GoalEnd(STATUS[ended.outcome], _failed(ended.message) if ended.message else {})

    async def _follow(self, goal: GoalHandle) -> GoalEnd:
        """Drive to one waypoint after the other, until one is missed."""
        poses = goal.goal.poses
        first = int(goal.goal.goal_index)
        if first >= len(poses):
            message = f"unknown first waypoint {first} (number of waypoints: {len(poses)})"
            return GoalEnd(Status.ABORTED, _failed(message))
        for _ in range(int(goal.goal.number_of_loops) + 1):
            for index in range(first, len(poses)):
                goal.publish_feedback({"current_waypoint": index})
                end = await self._drive([poses[index]], lambda _: None)
                if end.status is not Status.SUCCEEDED:
                    missed = {"index": index, "goal": poses[index], "error_code": FAILED}
                    return GoalEnd(end.status, {**end.result, "missed_waypoints": [missed]})
            first = 0
        return GoalEnd(Status.SUCCEEDED)


def _failed(message: str) -> dict[str, Any]:
    return {"error_code": FAILED, "error_msg": message}


def _pose(stamped: Any) -> wire.Pose3D:
    """Convert a `geometry_msgs/PoseStamped`.

    Raises:
        BackendRefused: The pose is invalid, or in an unsupported frame.
    """
    check_frame(stamped.header.frame_id, "the goal", Result.OPERATION_FAILED)
    return read_pose(stamped.pose, Result.OPERATION_FAILED)


@asynccontextmanager
async def serving_navigation(
    ros: RosNode, node: ExposedNode, robot: str, estimate: Callable[[], wire.Pose3D | None]
) -> AsyncIterator[None]:
    """Serve the navigation actions of a robot during the block; see `RobotNavigation`."""
    navigation = RobotNavigation(node, robot, estimate)
    async with AsyncExitStack() as stack:
        for action, kind in TYPES.items():
            execute, accept = partial(navigation.execute, action), partial(navigation.accept, action)
            served = serving_action(ros, action, f"nav2_msgs/action/{kind}", execute, accept)
            await stack.enter_async_context(served)
        yield
