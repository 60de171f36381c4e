"""The navigation of a robot as the actions of Nav2, carried out by the simulator node's own.

A goal takes the place of another of the same action, which is aborted, and is rejected while another action of the
robot has one: so does Nav2.
"""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from functools import partial
from typing import Any

from seoro.bridges import wire
from seoro.bridges.ros2 import geometry
from seoro.bridges.ros2.action_server import GoalEnd, ServedGoal, Status, serving_action
from seoro.bridges.ros2.expose.entities import check_frame
from seoro.bridges.ros2.expose.messages import MAP
from seoro.bridges.ros2.expose.node import ExposedNode
from seoro.bridges.ros2.expose.turns import Turns
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.wire import Outcome, Result
from seoro.errors import BackendRefused

TO_POSE, THROUGH_POSES, WAYPOINTS = "navigate_to_pose", "navigate_through_poses", "follow_waypoints"
TYPES = {TO_POSE: "NavigateToPose", THROUGH_POSES: "NavigateThroughPoses", WAYPOINTS: "FollowWaypoints"}
PERIOD = 0.5  # [s] of the simulator's clock between two messages of feedback
FAILED = 9000  # error code of Nav2 for what has no other

STATUS = {
    Outcome.SUCCEEDED: Status.SUCCEEDED,
    Outcome.CANCELED: Status.CANCELED,
    Outcome.ABORTED: Status.ABORTED,
}


class RobotNavigation:
    """Carries out the goals of a robot.

    Args:
        node: The simulator node that the robot is in.
        robot: Its name.
        believed: Says where it believes to be.
    """

    def __init__(self, node: ExposedNode, robot: str, believed: Callable[[], wire.Pose | None]) -> None:
        self._node = node
        self._robot = robot
        self._believed = believed
        self._turns = {action: Turns() for action in TYPES}

    def accept(self, action: str, goal: ServedGoal) -> bool:
        """Take a goal of an action, unless another action has one."""
        if any(turns.are_taken for other, turns in self._turns.items() if other != action):
            return False
        self._turns[action].reserve(goal)  # before anything else is accepted
        return True

    async def carry_out(self, action: str, goal: ServedGoal) -> GoalEnd:
        """Drive for a goal of an action."""
        replaced = GoalEnd(Status.ABORTED, _why("another goal has taken its place"))
        async with self._turns[action].take(goal, replaced):
            if action == WAYPOINTS:
                return await self._follow(goal)
            poses = [goal.goal.pose] if action == TO_POSE else goal.goal.poses
            return await self._drive(poses, self._teller(action, goal))

    def _teller(self, action: str, goal: ServedGoal) -> Callable[[wire.NavigationFeedback], None]:
        def tell(feedback: wire.NavigationFeedback) -> None:
            told = {
                "navigation_time": geometry.stamp(feedback.navigation_time),
                "estimated_time_remaining": geometry.stamp(feedback.estimated_time_remaining),
                "number_of_recoveries": feedback.number_of_recoveries,
                "distance_remaining": feedback.distance_remaining,
            }
            if action == THROUGH_POSES:
                told["number_of_poses_remaining"] = feedback.number_of_poses_remaining
            if (pose := self._believed()) is not None:
                told["current_pose"] = {
                    "header": geometry.header(MAP, feedback.time),
                    "pose": geometry.pose_message(pose),
                }
            goal.tell(told)

        return tell

    async def _drive(self, poses: Sequence[Any], told: Callable[[wire.NavigationFeedback], None]) -> GoalEnd:
        """Drive through poses, and stop at the last."""
        try:
            places = tuple(_place(stamped) for stamped in poses)

            def request(goal: str) -> wire.NavigateThroughPoses:
                return wire.NavigateThroughPoses(id=goal, robot=self._robot, poses=places, feedback_period=PERIOD)

            async with self._node.on_its_way(self._robot, told):
                ended = await self._node.pursue(wire.NAVIGATE_THROUGH_POSES, request)
        except BackendRefused as error:
            return GoalEnd(Status.ABORTED, _why(str(error)))
        return GoalEnd(STATUS[ended.outcome], _why(ended.message) if ended.message else {})

    async def _follow(self, goal: ServedGoal) -> GoalEnd:
        """Drive to one waypoint after the other; the first that is missed ends it."""
        poses = goal.goal.poses
        first = int(goal.goal.goal_index)
        if first >= len(poses):
            why = f"there is no waypoint {first} to begin with: there are {len(poses)}, from 0 on"
            return GoalEnd(Status.ABORTED, _why(why))
        for _ in range(int(goal.goal.number_of_loops) + 1):
            for index in range(first, len(poses)):
                goal.tell({"current_waypoint": index})
                end = await self._drive([poses[index]], lambda _: None)
                if end.status is not Status.SUCCEEDED:
                    missed = {"index": index, "goal": poses[index], "error_code": FAILED}
                    return GoalEnd(end.status, {**end.result, "missed_waypoints": [missed]})
            first = 0
        return GoalEnd(Status.SUCCEEDED)


def _why(message: str) -> dict[str, Any]:
    return {"error_code": FAILED, "error_msg": message}


def _place(stamped: Any) -> wire.Pose:
    """The pose of a `geometry_msgs/PoseStamped`.

    Raises:
        BackendRefused: It is in another frame, or none.
    """
    check_frame(stamped.header.frame_id, "the goal", Result.OPERATION_FAILED)
    try:
        return geometry.pose(stamped.pose)
    except ValueError as error:
        raise BackendRefused(str(error), Result.OPERATION_FAILED) from None


@asynccontextmanager
async def serving_navigation(
    ros: RosNode, node: ExposedNode, robot: str, believed: Callable[[], wire.Pose | None]
) -> AsyncIterator[None]:
    """Serve the actions of a robot's navigation for as long as the block lasts; see `RobotNavigation`."""
    navigation = RobotNavigation(node, robot, believed)
    async with AsyncExitStack() as stack:
        for action, kind in TYPES.items():
            carry_out, accept = partial(navigation.carry_out, action), partial(navigation.accept, action)
            served = serving_action(ros, action, f"nav2_msgs/action/{kind}", carry_out, accept)
            await stack.enter_async_context(served)
        yield
