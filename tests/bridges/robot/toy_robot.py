"""A robot with a base, an arm and a gripper in this process, which can break each rule of bridges."""

from __future__ import annotations

import math
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from contextlib import asynccontextmanager
from functools import partial
from pathlib import Path

import anyio

from seoro.bridges import wire
from seoro.bridges.robot.connecting import connect_robots
from seoro.bridges.robot.node import RobotNode
from seoro.bridges.serving.event_log import EventLog
from seoro.bridges.serving.node import serving
from seoro.bridges.serving.robot import Handlers
from seoro.bridges.serving.work import GoalAborted, Work
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused, check_finite
from seoro.security.network.listener import node_listener

TICK = 0.02  # [s]
SPEED = 0.35  # [m/s]
JOINT_SPEED = 2.0  # [rad/s]
JOINTS = ("shoulder", "elbow")
STROKE = 0.08  # [m]
NAME = "toy"


class ToyRobot:
    """A robot that drives along x.

    Args:
        faults: Names of its faults; `_has` asks for each.
        work: Goals and watches of the node.
        events: Log of events.
    """

    def __init__(self, faults: frozenset[str], work: Work, events: EventLog) -> None:
        self._faults = faults
        self._work = work
        self._events = events
        self._x = 0.0
        self._joints = [1.0, -0.5]
        self._opening = 0.03
        self._goals = 0

    @property
    def info(self) -> wire.RobotInfo:
        return wire.RobotInfo(name=NAME, kinds=("robot",), frames=("map",))

    @property
    def health(self) -> wire.RobotHealth:
        return wire.RobotHealth()

    @property
    def handlers(self) -> Handlers:
        return {
            wire.GET_LOCALIZATION: self._localization,
            wire.NAVIGATE_THROUGH_POSES: self._navigate,
            wire.GET_ROBOT_DESCRIPTION: self._describe,
            wire.GET_JOINT_STATES: self._joint_states,
            wire.FOLLOW_JOINT_TRAJECTORY: self._follow,
            wire.GRIPPER_COMMAND: self._grip,
            wire.GET_ARM_STATE: self._arm_state,
        }

    async def stop(self) -> None:
        """Do nothing: motions end with their goals."""

    def _has(self, fault: str) -> bool:
        return fault in self._faults

    def _start(self, identifier: str, work: Callable[[], Awaitable[str]], part: str) -> None:
        """Start a goal; a greedy robot accepts several at once."""
        self._goals += 1
        part = f"{part}{self._goals}" if self._has("accepts several goals") else part
        self._work.start(identifier, work, robot=NAME, part=part)

    # ------------------------------------------------------------ base

    async def _localization(self, _: wire.RobotName) -> wire.Localization:
        if self._has("is not localised"):
            return wire.Localization(pose=None, covariance=None, particles=0, error=None)
        x = math.nan if self._has("has an invalid pose") else self._x
        return wire.Localization(pose=wire.Pose3D(wire.Position3D(x=x)), covariance=None, particles=0, error=None)

    async def _navigate(self, request: wire.NavigateThroughPoses) -> None:
        if not request.poses and not self._has("accepts goals without poses"):
            raise RequestRefused(Result.OPERATION_FAILED, "expected a pose")
        target = request.poses[0].position.x if request.poses else self._x
        if not math.isfinite(target) and self._has("accepts invalid goals"):
            target = self._x
        check_finite("pose", target)
        self._start(request.id, partial(self._go, target), "")

    async def _go(self, target: float) -> str:
        if self._has("stops early"):
            target = self._x + (target - self._x) / 5.0
        if self._has("never arrives"):
            await anyio.sleep_forever()
        step, since = math.copysign(SPEED * TICK, target - self._x), 0.0
        try:
            while abs(target - self._x) > abs(step):
                await anyio.sleep(TICK)
                self._x += step
                since += TICK
                self._report(abs(target - self._x), since)
        except anyio.get_cancelled_exc_class():
            if self._has("coasts"):
                self._work._tasks.start_soon(self._coast, step)
            raise
        return ""

    async def _coast(self, step: float) -> None:
        for _ in range(200):
            await anyio.sleep(TICK)
            self._x += 5.0 * step  # far, also in few ticks on a busy machine

    def _report(self, left: float, since: float) -> None:
        if self._has("sends no feedback"):
            return
        if self._has("sends growing distances"):
            left = 5.0 * since
        if self._has("sends invalid distances"):
            left = math.inf
        if self._has("sends times that go back"):
            since = -since
        self._events.add(
            feedback=wire.NavigationFeedback(
                robot=NAME,
                time=self._events.now,
                navigation_time=since,
                distance_remaining=left,
                estimated_time_remaining=0.0,
                number_of_recoveries=0,
                number_of_poses_remaining=1,
            )
        )

    # ------------------------------------------------------------ arm

    async def _describe(self, _: wire.RobotName) -> wire.RobotDescription:
        described = wire.ArmDescription(joints=JOINTS, fingers=("finger",), stroke=STROKE)
        arm = None if self._has("describes no arm") else described
        return wire.RobotDescription(urdf="", base_link="base_link", sensors=(), arm=arm)

    async def _joint_states(self, _: wire.RobotName) -> wire.JointStates:
        names, positions = (*JOINTS, "finger"), (*self._joints, self._opening)
        if self._has("does not know a joint"):
            positions = (self._joints[0], math.nan, self._opening)
        return wire.JointStates(names=names, positions=positions, velocities=(0.0,) * 3, efforts=(0.0,) * 3)

    async def _follow(self, request: wire.FollowJointTrajectory) -> None:
        point = request.points[0]
        if set(request.joint_names) - {*JOINTS} and not self._has("accepts unknown joints"):
            raise RequestRefused(Result.NOT_FOUND, "unknown joint")
        if len(point) != len(request.joint_names) and not self._has("accepts missing joints"):
            raise RequestRefused(Result.OPERATION_FAILED, "expected a position for each joint")
        target = point[0]
        if not math.isfinite(target) and self._has("accepts invalid positions"):
            target = self._joints[0]
        check_finite("position", target)
        if abs(target) > math.tau and not self._has("accepts any position") and not self._has("aborts late"):
            raise RequestRefused(wire.ArmResult.OUT_OF_LIMITS, "beyond the limits")
        self._start(request.id, partial(self._turn, target, request.max_velocity_scaling_factor), "arm")

    async def _turn(self, target: float, scaling: float) -> str:
        if abs(target) > math.tau and self._has("aborts late"):
            raise GoalAborted("no plan found")
        if self._has("stops early"):
            return ""
        step = math.copysign(JOINT_SPEED * scaling * TICK, target - self._joints[0])
        if self._has("ignores the speed"):
            step = target - self._joints[0]
        try:
            while abs(target - self._joints[0]) > abs(step):
                await anyio.sleep(TICK)
                self._joints[0] += step
        except anyio.get_cancelled_exc_class():
            if self._has("coasts"):
                self._work._tasks.start_soon(self._coast_arm, step)
            raise
        return ""

    async def _coast_arm(self, step: float) -> None:
        for _ in range(100):
            await anyio.sleep(TICK)
            self._joints[0] += 5.0 * step

    async def _grip(self, request: wire.GripperCommand) -> None:
        opening = request.opening
        if self._has("clips openings"):
            opening = max(0.0, opening)
        if not 0.0 <= opening <= STROKE:
            raise RequestRefused(Result.OPERATION_FAILED, "expected an opening within the stroke")

        async def grip() -> str:
            self._opening = max(opening, 0.02) if self._has("does not close") else opening
            return ""

        self._work.start(request.id, grip, robot=NAME, part="gripper")

    async def _arm_state(self, _: wire.RobotName) -> wire.ArmState:
        return wire.ArmState(tool=wire.Pose3D(), opening=self._opening, held="", remaining=0.0)


@asynccontextmanager
async def toy(folder: Path, *faults: str) -> AsyncIterator[tuple[RobotNode, str]]:
    """Yield a held robot with faults, and the endpoint of its bridge."""
    endpoint = f"unixsock-stream/{folder}/toy"

    def make(work: Work, events: EventLog) -> Sequence[ToyRobot]:
        return [ToyRobot(frozenset(faults), work, events)]

    async with (
        serving(node_listener(endpoint, None, "toys"), "toys", make),
        connect_robots(endpoint, "a test") as node,
    ):
        yield node, endpoint
