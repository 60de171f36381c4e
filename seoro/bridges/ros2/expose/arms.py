"""The controllers of an arm as actions of ros2_control, executed by the controllers of the simulator node."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from contextlib import asynccontextmanager
from typing import Any

import numpy as np

from seoro.bridges import wire
from seoro.bridges.ros2 import geometry
from seoro.bridges.ros2.action_server import GoalEnd, GoalHandle, Status, serving_action
from seoro.bridges.ros2.expose.goal_queue import GoalQueue
from seoro.bridges.ros2.expose.node import ExposedNode
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.urdf import Links
from seoro.bridges.wire import Outcome
from seoro.errors import BackendRefused

TRAJECTORY = "joint_trajectory_controller/follow_joint_trajectory"
GRIPPER = "gripper_controller/gripper_cmd"
INVALID_GOAL, PATH_TOLERANCE_VIOLATED = -1, -4  # error codes of FollowJointTrajectory
MIN_SCALING = 0.01  # of the maximum joint speeds
PEAK = 1.875  # ratio of peak and mean speed on a trajectory of the node
TOLERANCE = 2e-3  # [m] of a reached opening

Positions = Callable[[], Mapping[str, float]]


class ExposedArm:
    """Execution of the goals of an arm and its gripper.

    Args:
        node: Simulator node of the robot.
        robot: Name of the robot.
        links: Links and joints of the robot.
        positions: Returns the positions of the joints [rad, m].
    """

    def __init__(self, node: ExposedNode, robot: str, links: Links, positions: Positions) -> None:
        self._node = node
        self._robot = robot
        self._speeds = {joint.name: joint.speed for joint in links.joints}
        self._positions = positions
        self._moving, self._gripping = GoalQueue(), GoalQueue()

    async def follow(self, goal: GoalHandle) -> GoalEnd:
        """Follow a trajectory of joints."""
        names = tuple(goal.goal.trajectory.joint_names)
        points = goal.goal.trajectory.points
        configurations = tuple(tuple(map(float, point.positions)) for point in points)
        duration = geometry.seconds(points[-1].time_from_start) if points else 0.0
        request = wire.FollowJointTrajectory(
            id=self._node.new_id(),
            robot=self._robot,
            points=configurations,
            joint_names=names,
            max_velocity_scaling_factor=self._scaling(names, configurations, duration),
        )
        replaced = GoalEnd(Status.ABORTED, _failed(INVALID_GOAL, "replaced by another goal"))
        async with self._moving.turn(goal, replaced):
            try:
                ended = await self._node.pursue(wire.FOLLOW_JOINT_TRAJECTORY, request)
            except BackendRefused as error:
                return GoalEnd(Status.ABORTED, _failed(INVALID_GOAL, str(error)))
        if ended.outcome is Outcome.SUCCEEDED:
            return GoalEnd(Status.SUCCEEDED)
        return GoalEnd(Status.ABORTED, _failed(PATH_TOLERANCE_VIOLATED, ended.message))

    def _scaling(self, names: Sequence[str], configurations: Sequence[Sequence[float]], duration: float) -> float:
        """Return the speed factor at which a trajectory takes about a duration [s]; 1 without a duration."""
        now, count = self._positions(), len(names)
        if duration <= 0.0 or any(name not in now for name in names):
            return 1.0
        if not names or any(len(each) != count for each in configurations):
            return 1.0  # the node refuses the trajectory
        travels = np.abs(np.diff([[now[name] for name in names], *configurations], axis=0))
        lengths = np.linalg.norm(travels, axis=1)
        moving = lengths > 0.0
        if not moving.any():
            return 1.0
        shares = travels[moving] / (lengths[moving] / lengths.sum())[:, None]
        speeds = [self._speeds.get(name, np.inf) for name in names]
        fastest = PEAK * float((shares / speeds).max())  # [s] at full speed
        return min(1.0, max(MIN_SCALING, fastest / duration))

    async def grip(self, goal: GoalHandle) -> GoalEnd:
        """Open or close the gripper: `position` is the opening [m], `max_effort` the force [N], if above zero."""
        command = goal.goal.command
        opening, force = float(command.position), float(command.max_effort)
        request = wire.GripperCommand(
            id=self._node.new_id(), robot=self._robot, opening=opening, force=force if force > 0.0 else None
        )
        async with self._gripping.turn(goal, GoalEnd(Status.ABORTED)):
            ended = await self._node.pursue(wire.GRIPPER_COMMAND, request)
            state = await self._node.ask(wire.GET_ARM_STATE, wire.RobotName(robot=self._robot))
        reached = abs(state.opening - opening) < TOLERANCE
        result = {"position": state.opening, "effort": force, "stalled": not reached, "reached_goal": reached}
        return GoalEnd(Status.SUCCEEDED if ended.outcome is Outcome.SUCCEEDED else Status.ABORTED, result)


def _failed(code: int, message: str) -> dict[str, Any]:
    return {"error_code": code, "error_string": message}


@asynccontextmanager
async def serving_arm(ros: RosNode, arm: ExposedArm) -> AsyncIterator[None]:
    """Serve the actions of the controllers of an arm during the block."""
    async with (
        serving_action(ros, TRAJECTORY, "control_msgs/action/FollowJointTrajectory", arm.follow),
        serving_action(ros, GRIPPER, "control_msgs/action/GripperCommand", arm.grip),
    ):
        yield
