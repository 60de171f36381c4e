"""An arm: motions that MoveIt plans, or its controller follows, and its gripper."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from typing import Any

from seoro.bridges import wire
from seoro.bridges.ros2.robots import motions
from seoro.bridges.ros2.robots.frames import Frames
from seoro.bridges.ros2.robots.joints import Joints
from seoro.bridges.ros2.robots.link import Link
from seoro.bridges.ros2.robots.profile import Arm, Gripper, MoveGroup
from seoro.bridges.ros2.robots.pursuit import ActionGoal, pursue
from seoro.bridges.serving.robot import Carry, Handlers
from seoro.bridges.serving.work import Aborted, Work
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused, check_finite, check_positive, listed

MAX_POINTS = 1000
PLANS, FOLLOWS, GRIPS = (
    "moveit_msgs/action/MoveGroup",
    "control_msgs/action/FollowJointTrajectory",
    "control_msgs/action/GripperCommand",
)
ARM, GRIPPER = "arm", "gripper"
MAP = "map"
SOMETHING = "something"  # is all that a gripper can say of what it holds
CLOSED = 3e-3  # opening [m] at which fingers are stopped by each other, and hold nothing
HELD_WITHIN = 2e-3  # [m] of where the fingers were stopped
TOLD_WITHIN = 0.2  # [s] from the end of a motion until positions of joints that were told before it count no more


class MovingArm:
    """The arm of a robot.

    Args:
        link: To the robot.
        arm: What it calls things.
        frames: Where its frames are.
        robot: Its name.
        work: Where goals and watches run.
    """

    def __init__(self, link: Link, arm: Arm, frames: Frames, robot: str, work: Work) -> None:
        self._link = link
        self._arm = arm
        self._frames = frames
        self._stopped_at: float | None = None  # opening at which something stopped the fingers [m]
        self._stopped = 0.0  # when that was, by the machine's clock [s]
        self._robot = robot
        self._work = work
        gripper = () if arm.gripper is None else (arm.gripper.joint,)
        self._joints = Joints(link, arm.joint_states, (*arm.joints, *gripper), work)

    @property
    def handlers(self) -> Handlers:
        """The verbs that it serves."""
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

    async def open(self) -> None:
        """Listen to the robot."""
        await self._joints.open()

    async def _follow(self, request: wire.FollowJointTrajectory) -> wire.Empty:
        _check_motion(request)
        names = request.joint_names or tuple(self._arm.joints)
        self._check_points(request, names)
        group = self._arm.move_group
        if group is not None and len(request.points) == 1:
            positions = dict(zip(names, request.points[0], strict=True))
            await self._plan(request, group, motions.joint_goal(group, positions, request))
            return wire.Empty()
        if request.plan_only:
            raise RequestRefused(Result.FEATURE_UNSUPPORTED, "nothing on the robot plans: leave out `plan_only`")
        start = [await self._joints.position(name) for name in names]
        speeds = [self._arm.joints[name] for name in names]
        goal = motions.trajectory_goal(names, request.points, start, speeds, request)
        action = ActionGoal(self._arm.trajectory, FOLLOWS, goal, part=ARM, judge=motions.judge_trajectory)
        await pursue(self._link, self._work, request.id, self._robot, action)
        return wire.Empty()

    def _check_points(self, request: wire.FollowJointTrajectory, names: tuple[str, ...]) -> None:
        unknown = [name for name in names if name not in self._arm.joints]
        if unknown:
            raise RequestRefused(
                Result.NOT_FOUND, f"the arm has no joints {listed(unknown)}: it has {listed(self._arm.joints)}"
            )
        if not 1 <= len(request.points) <= MAX_POINTS:
            raise RequestRefused(
                Result.OPERATION_FAILED, f"{len(request.points)} points were given: give 1 to {MAX_POINTS}"
            )
        for point in request.points:
            if len(point) != len(names):
                raise RequestRefused(
                    Result.OPERATION_FAILED, f"{len(point)} positions were given for {len(names)} joints"
                )
            check_finite("position", *point)

    async def _move_to_pose(self, request: wire.MoveToPose) -> wire.Empty:
        _check_motion(request)
        place, turned = request.pose.position, request.pose.orientation
        check_finite("pose", place.x, place.y, place.z, turned.roll, turned.pitch, turned.yaw)
        group = self._arm.move_group
        assert group is not None, "only then the verb is served"
        await self._plan(request, group, motions.pose_goal(self._arm, group, request))
        return wire.Empty()

    async def _plan(self, request: wire.ArmMotion, group: MoveGroup, goal: Mapping[str, Any]) -> None:
        action = ActionGoal(group.action, PLANS, goal, part=ARM, judge=motions.judge_plan)
        await pursue(self._link, self._work, request.id, self._robot, action)

    async def _grip(self, request: wire.GripperCommand) -> wire.Empty:
        gripper = self._arm.gripper
        assert gripper is not None, "only then the verb is served"
        check_finite("opening", request.opening)
        if not 0.0 <= request.opening <= gripper.widest:
            raise RequestRefused(
                Result.OPERATION_FAILED, f"the gripper opens 0 to {gripper.widest:g} m, not {request.opening:g} m"
            )
        force = gripper.force if request.force is None else request.force
        check_positive("force", force)
        position = gripper.closed + gripper.per_metre * request.opening
        closes = request.opening < await self._opening(gripper)

        def judge(result: Mapping[str, Any]) -> str:
            return self._judge_grip(result, gripper, request, closes=closes)

        goal = {"command": {"position": position, "max_effort": force}}
        action = ActionGoal(gripper.action, GRIPS, goal, part=GRIPPER, judge=judge)
        await pursue(self._link, self._work, request.id, self._robot, action)
        return wire.Empty()

    def _judge_grip(
        self, result: Mapping[str, Any], gripper: Gripper, request: wire.GripperCommand, *, closes: bool
    ) -> str:
        """What a gripper says: the opening is reached, or something stopped fingers that closed."""
        opening = (float(result["position"]) - gripper.closed) / gripper.per_metre
        meets_itself = closes and opening <= CLOSED
        if result["reached_goal"] or meets_itself or abs(opening - request.opening) <= request.tolerance:
            self._stopped_at = None
            return ""
        if not math.isfinite(opening):
            self._stopped_at = None
            raise Aborted(
                f"the gripper does not say how far open it is: its result has the position {result['position']}"
            )
        if result["stalled"] and closes:
            self._stopped_at, self._stopped = opening, time.monotonic()
            return f"something stopped the fingers at {opening:.3f} m"
        raise Aborted(f"the gripper has an opening of {opening:.3f} m, not of {request.opening:.3f} m")

    async def _opening(self, gripper: Gripper) -> float:
        return (await self._joints.position(gripper.joint) - gripper.closed) / gripper.per_metre

    async def _state(self, _request: wire.RobotName) -> wire.ArmState:
        gripper = self._arm.gripper
        opening = 0.0 if gripper is None else await self._opening(gripper)
        is_fresh = time.monotonic() < self._stopped + TOLD_WITHIN
        holds = self._stopped_at is not None and (is_fresh or abs(opening - self._stopped_at) <= HELD_WITHIN)
        return wire.ArmState(tool=self._tool(), opening=opening, held=SOMETHING if holds else "", remaining=0.0)

    def _tool(self) -> wire.Pose:
        """Where the tool is, in the map if there is one, else in the frame of the arm's base."""
        parent = MAP if MAP in self._frames.names else self._arm.base_frame
        pose = self._frames.pose(self._arm.tool, parent)
        if pose is None:
            raise RequestRefused(
                Result.INCORRECT_STATE,
                f"where the tool is, frame '{self._arm.tool}' in '{parent}', the robot does not say",
            )
        return pose


def _check_motion(request: wire.ArmMotion) -> None:
    check_positive("tolerance", request.tolerance)
    if not 0.0 < request.max_velocity_scaling_factor <= 1.0:
        raise RequestRefused(
            Result.OPERATION_FAILED,
            f"the factor of the speed is {request.max_velocity_scaling_factor}: it is above 0, and 1 at most",
        )
    if request.may_touch:
        raise RequestRefused(
            Result.FEATURE_UNSUPPORTED,
            f"the planner of the robot cannot be told that it may touch {listed(request.may_touch)}",
        )
