"""Arm of a robot: motions planned by MoveIt or followed by its controller, and its gripper."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from typing import Any

from seoro.bridges import wire
from seoro.bridges.ros2.robots import motions
from seoro.bridges.ros2.robots.joints import Joints
from seoro.bridges.ros2.robots.link import RobotLink
from seoro.bridges.ros2.robots.navigation import check_pose
from seoro.bridges.ros2.robots.profile import Arm, Gripper, MoveGroup
from seoro.bridges.ros2.robots.pursuit import ActionGoal, pursue
from seoro.bridges.serving.robot import Carry, Handlers
from seoro.bridges.serving.work import GoalAborted
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused, check_finite, check_positive, name_list

MAX_POINTS = 1000
PLANS, FOLLOWS, GRIPS = (
    "moveit_msgs/action/MoveGroup",
    "control_msgs/action/FollowJointTrajectory",
    "control_msgs/action/GripperCommand",
)
ARM, GRIPPER = "arm", "gripper"
MAP = "map"
UNKNOWN_OBJECT = "something"  # name of a held object, which the gripper does not know
CLOSED = 3e-3  # opening [m] at which the fingers touch each other, and hold nothing
HELD_TOLERANCE = 2e-3  # [m] from the opening at which the fingers were stopped
STATE_DELAY = 0.2  # [s] after a motion in which joint states may be from before its end


class MovingArm:
    """Arm of a robot.

    Args:
        link: Link to the robot.
        arm: Names of the topics and actions of the arm.
    """

    def __init__(self, link: RobotLink, arm: Arm) -> None:
        self._link = link
        self._arm = arm
        self._stopped_at: float | None = None  # opening at which an object stopped the fingers [m]
        self._stopped = 0.0  # time of that, by the machine's clock [s]
        gripper = () if arm.gripper is None else (arm.gripper.joint,)
        self._joints = Joints(link, arm.joint_states, (*arm.joints, *gripper))

    @property
    def handlers(self) -> Handlers:
        """Handlers of the served verbs."""
        served: dict[wire.Verb[Any, Any], Carry] = {
            **self._joints.handlers,
            wire.FOLLOW_JOINT_TRAJECTORY: self._follow,
            wire.GET_ARM_STATE: self._state,
        }
        if self._arm.move_group is not None:
            served[wire.MOVE_TO_POSE] = self._move_to_pose
        if self._arm.gripper is not None:
            served[wire.GRIPPER_COMMAND] = self._grip
        return served

    @property
    def description(self) -> wire.ArmDescription:
        """Joints of the arm and its gripper, and the stroke of the gripper."""
        gripper = self._arm.gripper
        return wire.ArmDescription(
            joints=tuple(self._arm.joints),
            fingers=() if gripper is None else (gripper.joint,),
            stroke=0.0 if gripper is None else gripper.widest,
        )

    async def open(self) -> None:
        """Subscribe to the joint states."""
        await self._joints.open()

    async def _follow(self, request: wire.FollowJointTrajectory) -> None:
        _check_motion(request)
        names = request.joint_names or tuple(self._arm.joints)
        self._check_points(request, names)
        group = self._arm.move_group
        if group is not None and len(request.points) == 1:
            positions = dict(zip(names, request.points[0], strict=True))
            await self._plan(request, group, motions.joint_goal(group, positions, request))
            return
        if request.plan_only:
            raise RequestRefused(Result.FEATURE_UNSUPPORTED, "the robot has no planner: leave out `plan_only`")
        start = [await self._joints.position(name) for name in names]
        speeds = [self._arm.joints[name] for name in names]
        goal = motions.trajectory_goal(names, request.points, start, speeds, request)
        action = ActionGoal(self._arm.trajectory, FOLLOWS, goal, part=ARM)
        await pursue(self._link, request.id, action)

    def _check_points(self, request: wire.FollowJointTrajectory, names: tuple[str, ...]) -> None:
        unknown = [name for name in names if name not in self._arm.joints]
        if unknown:
            raise RequestRefused(
                Result.NOT_FOUND,
                f"unknown joints {name_list(unknown)} (joints of the arm: {name_list(self._arm.joints)})",
            )
        if not 1 <= len(request.points) <= MAX_POINTS:
            raise RequestRefused(
                Result.OPERATION_FAILED, f"expected 1 to {MAX_POINTS} points, got {len(request.points)}"
            )
        for point in request.points:
            if len(point) != len(names):
                raise RequestRefused(
                    Result.OPERATION_FAILED, f"expected positions of {len(names)} joints, got {len(point)}"
                )
            check_finite("position", *point)
            self._check_limits(dict(zip(names, point, strict=True)))

    def _check_limits(self, positions: Mapping[str, float]) -> None:
        for name, position in positions.items():
            lowest, highest = self._arm.limits.get(name, (-math.inf, math.inf))
            if not lowest <= position <= highest:
                raise RequestRefused(
                    wire.ArmResult.OUT_OF_LIMITS,
                    f"position {position:g} of '{name}' is out of its limits; expected {lowest:g} to {highest:g} "
                    "(`limits` in the profile of the robot)",
                )

    async def _move_to_pose(self, request: wire.MoveToPose) -> None:
        _check_motion(request)
        check_pose(request.pose)
        group = self._arm.move_group
        assert group is not None, "the verb is served with a group only"
        await self._plan(request, group, motions.pose_goal(self._arm, group, request))

    async def _plan(self, request: wire.ArmMotion, group: MoveGroup, goal: Mapping[str, Any]) -> None:
        action = ActionGoal(group.action, PLANS, goal, part=ARM)
        await pursue(self._link, request.id, action)

    async def _grip(self, request: wire.GripperCommand) -> None:
        gripper = self._arm.gripper
        assert gripper is not None, "the verb is served with a gripper only"
        check_finite("opening", request.opening)
        if not 0.0 <= request.opening <= gripper.widest:
            raise RequestRefused(
                Result.OPERATION_FAILED,
                f"expected an opening of 0 to {gripper.widest:g} m, got {request.opening:g} m",
            )
        force = gripper.force if request.force is None else request.force
        check_positive("force", force)
        position = gripper.closed + gripper.per_metre * request.opening
        closes = request.opening < await self._opening(gripper)

        def judge(result: Mapping[str, Any]) -> str:
            return self._judge_grip(result, gripper, request, closes=closes)

        goal = {"command": {"position": position, "max_effort": force}}
        action = ActionGoal(gripper.action, GRIPS, goal, part=GRIPPER, judge=judge)
        await pursue(self._link, request.id, action)

    def _judge_grip(
        self, result: Mapping[str, Any], gripper: Gripper, request: wire.GripperCommand, *, closes: bool
    ) -> str:
        """Judge the result of a gripper: the opening is reached, or an object stopped the closing fingers."""
        opening = (float(result["position"]) - gripper.closed) / gripper.per_metre
        is_closed = closes and opening <= CLOSED
        if result["reached_goal"] or is_closed or abs(opening - request.opening) <= request.tolerance:
            self._stopped_at = None
            return ""
        if not math.isfinite(opening):
            self._stopped_at = None
            raise GoalAborted(
                f"the gripper has sent no valid opening: the position of its result is {result['position']}"
            )
        if result["stalled"] and closes:
            self._stopped_at, self._stopped = opening, time.monotonic()
            return f"an object stopped the fingers at {opening:.3f} m"
        raise GoalAborted(f"the gripper has an opening of {opening:.3f} m instead of {request.opening:.3f} m")

    async def _opening(self, gripper: Gripper) -> float:
        return (await self._joints.position(gripper.joint) - gripper.closed) / gripper.per_metre

    async def _state(self, _request: wire.RobotName) -> wire.ArmState:
        gripper = self._arm.gripper
        opening = 0.0 if gripper is None else await self._opening(gripper)
        is_recent = time.monotonic() < self._stopped + STATE_DELAY
        holds = self._stopped_at is not None and (is_recent or abs(opening - self._stopped_at) <= HELD_TOLERANCE)
        held = UNKNOWN_OBJECT if holds else ""
        return wire.ArmState(tool=self._tool_pose(), opening=opening, held=held, remaining=0.0)

    def _tool_pose(self) -> wire.Pose3D:
        """Return the pose of the tool in the map if the frame is known, else in the base frame of the arm."""
        parent = MAP if MAP in self._link.frames.names else self._arm.base_frame
        pose = self._link.frames.pose(self._arm.tool, parent)
        if pose is None:
            raise RequestRefused(
                Result.INCORRECT_STATE,
                f"unknown pose of the tool: no transform of '{self._arm.tool}' in '{parent}'",
            )
        return pose


def _check_motion(request: wire.ArmMotion) -> None:
    check_positive("tolerance", request.tolerance)
    if not 0.0 < request.max_velocity_scaling_factor <= 1.0:
        raise RequestRefused(
            Result.OPERATION_FAILED,
            f"invalid speed factor {request.max_velocity_scaling_factor}: expected a number above 0, 1 at most",
        )
    if request.may_touch:
        raise RequestRefused(
            Result.FEATURE_UNSUPPORTED,
            f"the planner of the robot does not support `may_touch` ({name_list(request.may_touch)})",
        )
