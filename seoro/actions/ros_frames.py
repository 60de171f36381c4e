"""Actions of `osc.ros` for the motion of a robot and its frames.

Robots of a simulator are watched by the simulator; other robots by their topics: `tf`, `tf_static` and `odom` in
the namespace of the robot.
"""

from __future__ import annotations

import math
import time
from collections.abc import Awaitable, Callable
from functools import partial

import anyio

from seoro.actions.reports import finish, meanwhile
from seoro.actions.ros_only import refuse_unless
from seoro.actions.ros_robots import observed_names
from seoro.actions.ros_support import as_action_failure, log_missing, next_message, observed_system
from seoro.errors import ActionFailed, BackendLost
from seoro.robotics.geometry import Position3D
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.robots import MobileRobots
from seoro.runtime.contracts.ros2 import FramePose, ObservedSystem, RosClock, RosFrames
from seoro.runtime.functions.actions import action
from seoro.runtime.values.values import Actor

ODOMETRY = "nav_msgs/msg/Odometry"
DEFAULT_QOS = "system_default"
WINDOW = 0.2  # [s] over which the speed of a frame is measured; shorter windows measure noise


@action("differential_drive_robot.tf_close_to", home=MobileRobots | ObservedSystem)
async def tf_close_to(
    ctx: ActionContext,
    robot: Actor,
    threshold: float,
    reference_point: Position3D,
    robot_frame_id: str,
    sim: bool,
    namespace_override: str,
    parent_frame_id: str,
) -> None:
    """Wait until a frame of the robot is within a distance of a point, in the plane of the parent frame."""
    # `sim` selects between two clocks of ROS; here the stamps of the transforms apply.
    if ctx.is_home(robot, MobileRobots):
        refuse_unless(namespace_override=(namespace_override, ""))
        robots, name = ctx.home(robot, MobileRobots)
        watch = partial(robots.watch_proximity, name, robot_frame_id, parent_frame_id, reference_point, threshold)
        await finish(ctx, watch, robots.cancel_watch)
        return
    system, name = ctx.home(robot, ObservedSystem)
    names = observed_names(robot, system, name, namespace_override)
    distance = math.inf
    with as_action_failure():
        async with system.frames(names.frames, lambda text: ctx.relay([text])) as frames:
            with log_missing(ctx, lambda: _far(frames, robot_frame_id, parent_frame_id, distance, threshold)):
                while distance > threshold:
                    pose = await meanwhile(ctx, frames.next_pose(robot_frame_id, parent_frame_id))
                    x, y, _ = pose.position
                    distance = math.hypot(x - reference_point.x, y - reference_point.y)


def _far(frames: RosFrames, frame: str, parent: str, distance: float, threshold: float) -> str:
    if absence := frames.describe_absence(frame, parent):
        return f"a pose of `{frame}` in `{parent}`: {absence}"
    return f"`{frame}` within {threshold:g} m of the point; it is {distance:.3g} m away"


@action("differential_drive_robot.odometry_distance_traveled", home=MobileRobots | ObservedSystem)
async def odometry_distance_traveled(
    ctx: ActionContext, robot: Actor, distance: float, namespace_override: str
) -> None:
    """Wait until the robot's odometry has counted a distance."""
    if ctx.is_home(robot, MobileRobots):
        refuse_unless(namespace_override=(namespace_override, ""))
        robots, name = ctx.home(robot, MobileRobots)
        await finish(ctx, partial(robots.watch_distance, name, distance), robots.cancel_watch)
        return
    system, name = ctx.home(robot, ObservedSystem)
    names = observed_names(robot, system, name, namespace_override)
    topic = names.full(names.odometry)
    travelled, last = 0.0, None
    with as_action_failure(), log_missing(ctx, lambda: f"{distance:g} m on {topic}; found {travelled:.3g} m"):
        async with system.subscribing(topic, ODOMETRY, DEFAULT_QOS) as odometry:
            while travelled < distance:
                message = (await next_message(ctx, odometry)).message
                position = message.pose.pose.position
                if not math.isfinite(position.x) or not math.isfinite(position.y):
                    raise ActionFailed(f"invalid position on {topic}: x {position.x:g}, y {position.y:g}")
                if last is not None:
                    travelled += math.hypot(position.x - last.x, position.y - last.y)
                last = position


# ---------------------------------------------------------------- movement


@action("assert_tf_moving", anywhere=ObservedSystem, open_ended=True)
async def assert_tf_moving(
    ctx: ActionContext,
    frame_id: str,
    parent_frame_id: str,
    timeout: float,
    threshold_translation: float,
    threshold_rotation: float,
    wait_for_first_transform: bool,
    tf_topic_namespace: str,
    use_sim_time: bool,
) -> None:
    """Watch a frame, and fail if it does not move or turn fast enough for too long."""
    if timeout <= 0.0:
        raise ActionFailed(f"invalid `timeout`: expected more than 0 s, found {timeout:g} s")
    movement, system = _Movement(threshold_translation, threshold_rotation), observed_system(ctx)
    waited = time.monotonic()  # start of the current wait, on the clock of outages

    def note(text: str) -> None:
        ctx.relay([text])

    with as_action_failure():
        async with system.frames(tf_topic_namespace, note) as frames, system.clock(note) as followed:
            clock = _Time(followed if use_sim_time else system.machine_clock())
            poses = partial(frames.next_pose, frame_id, parent_frame_id)
            rested = await meanwhile(ctx, clock.started())  # time of the last known motion
            if wait_for_first_transform:
                movement.take(await meanwhile(ctx, poses()))
                rested, waited = clock.now(), time.monotonic()
            while True:
                pose = await meanwhile(ctx, _until(poses, clock, rested + timeout))
                is_moving = pose is not None and movement.take(pose)
                if clock.has_jumped() or is_moving:
                    rested, waited = clock.now(), time.monotonic()
                elif clock.now() >= rested + timeout:
                    if loss := system.loss_since(waited):
                        raise BackendLost(loss)
                    absence = frames.describe_absence(frame_id, parent_frame_id)
                    raise ActionFailed(absence or movement.describe_stillness(frame_id, parent_frame_id, timeout))


class _Time:
    """The time on a clock [s], which may be paused.

    Args:
        clock: The clock.
    """

    def __init__(self, clock: RosClock) -> None:
        self._clock = clock
        self._jumps = clock.jumps
        self._now = -math.inf  # last known time, used until a new clock publishes one

    async def started(self) -> float:
        """Wait for the first clock message; return the time."""
        await self._clock.wait_until(-math.inf)
        return self.now()

    def now(self) -> float:
        """Return the current time."""
        found = self._clock.now()
        self._now = self._now if found is None else found
        return self._now

    async def wait_until(self, moment: float) -> None:
        """Wait until a time, or until the clock jumps."""
        await self._clock.wait_until(moment)

    def has_jumped(self) -> bool:
        """Whether the clock has jumped since the last call."""
        before, self._jumps = self._jumps, self._clock.jumps
        return self._jumps != before


async def _until(poses: Callable[[], Awaitable[FramePose]], clock: _Time, moment: float) -> FramePose | None:
    """Return the next pose, or None if a time is reached first."""
    pose: FramePose | None = None

    async def take() -> None:
        nonlocal pose
        pose = await poses()
        tasks.cancel_scope.cancel()

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(take)
        await clock.wait_until(moment)
        tasks.cancel_scope.cancel()
    return pose


class _Movement:
    """Speed and turning rate of a frame, by the stamps of its poses.

    Args:
        speed: Threshold of motion [m/s].
        rate: Threshold of rotation [rad/s].
    """

    def __init__(self, speed: float, rate: float) -> None:
        self._thresholds = speed, rate
        self._from: FramePose | None = None  # start of the window
        self._now = 0.0  # last stamp [s]
        self._speeds = 0.0, 0.0

    def take(self, pose: FramePose) -> bool:
        """Add a pose; return whether the frame has moved fast enough."""
        now = self._now if pose.stamp is None else pose.stamp
        if self._from is None or self._from.stamp is None or now < self._from.stamp:  # the time was reset
            self._from, self._now = pose, now
            return False
        self._now = now
        period = now - self._from.stamp
        if period < WINDOW:
            return False
        moved = math.dist(pose.position, self._from.position)
        turned = _angle(pose.rotation, self._from.rotation)
        self._from, self._speeds = pose, (moved / period, turned / period)
        return any(found >= least for found, least in zip(self._speeds, self._thresholds, strict=True))

    def describe_stillness(self, frame: str, parent: str, timeout: float) -> str:
        """Return the text for "the frame does not move"."""
        speed, rate = self._speeds
        return f"`{frame}` has not moved in `{parent}` for {timeout:g} s: {speed:.3g} m/s and {rate:.3g} rad/s"


def _angle(a: tuple[float, float, float, float], b: tuple[float, float, float, float]) -> float:
    """Return the angle between two rotations [rad]."""
    return 2 * math.acos(min(1.0, abs(sum(p * q for p, q in zip(a, b, strict=True)))))
