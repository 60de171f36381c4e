"""Actions of `osc.nav2` for short motions: the behaviors of Nav2.

Robots of a simulator or behind a bridge are driven by velocities for the time that the motion takes.
"""

from __future__ import annotations

import math
from functools import partial
from typing import NamedTuple

from seoro.actions.goals import pursue
from seoro.actions.nav2_requests import BASE, duration, run_goal
from seoro.actions.ros_only import refuse_unless
from seoro.actions.ros_robots import full_name
from seoro.errors import ActionFailed
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.robots import DrivenRobots
from seoro.runtime.contracts.ros2 import Members, Ros2System
from seoro.runtime.functions.actions import action
from seoro.runtime.values.values import Actor

TURN_RATE = 0.5  # [rad/s] of turns by velocity; faster ones end earlier, since wheels accelerate


@action("differential_drive_robot.spin", home=DrivenRobots | Ros2System, uses=BASE)
async def spin(
    ctx: ActionContext,
    robot: Actor,
    angle: float,
    time_limit: float,
    check_collisions: bool,
    namespace_override: str,
) -> None:
    """Turn on the spot by an angle."""
    if ctx.is_home(robot, DrivenRobots):
        refuse_unless(namespace_override=(namespace_override, ""))
        rate = math.copysign(TURN_RATE, angle)
        await _drive(ctx, robot, 0.0, rate, abs(angle) / TURN_RATE, time_limit)
        return
    goal = {"target_yaw": angle, **_limits(time_limit, check_collisions=check_collisions)}
    await run_goal(ctx, full_name(robot, namespace_override, "spin"), "Spin", goal)


@action("differential_drive_robot.backup", home=DrivenRobots | Ros2System, uses=BASE)
async def backup(
    ctx: ActionContext,
    robot: Actor,
    distance: float,
    speed: float,
    time_limit: float,
    check_collisions: bool,
    namespace_override: str,
) -> None:
    """Drive backwards in a straight line."""
    motion = _Straight("backup", "BackUp", -1.0, distance, speed)
    await _move_straight(ctx, robot, motion, time_limit, namespace_override, check_collisions=check_collisions)


@action("differential_drive_robot.drive_on_heading", home=DrivenRobots | Ros2System, uses=BASE)
async def drive_on_heading(
    ctx: ActionContext,
    robot: Actor,
    distance: float,
    speed: float,
    time_limit: float,
    check_collisions: bool,
    namespace_override: str,
) -> None:
    """Drive ahead in a straight line."""
    motion = _Straight("drive_on_heading", "DriveOnHeading", 1.0, distance, speed)
    await _move_straight(ctx, robot, motion, time_limit, namespace_override, check_collisions=check_collisions)


@action("differential_drive_robot.wait_in_place", home=DrivenRobots | Ros2System, uses=BASE)
async def wait_in_place(ctx: ActionContext, robot: Actor, length: float, namespace_override: str) -> None:
    """Stand still for a time."""
    if ctx.is_home(robot, DrivenRobots):
        refuse_unless(namespace_override=(namespace_override, ""))
        await ctx.sleep(length)
        return
    await run_goal(ctx, full_name(robot, namespace_override, "wait"), "Wait", {"time": duration(length)})


@action("differential_drive_robot.assisted_teleop", anywhere=Ros2System, uses=BASE)
async def assisted_teleop(ctx: ActionContext, robot: Actor, time_limit: float, namespace_override: str) -> None:
    """Follow the velocities on `cmd_vel_teleop` for a time, and stop before obstacles."""
    goal = {"time_allowance": duration(time_limit)}
    await run_goal(ctx, full_name(robot, namespace_override, "assisted_teleop"), "AssistedTeleop", goal)


class _Straight(NamedTuple):
    """A motion in a straight line.

    Args:
        action: Name of the action of Nav2.
        kind: Its type.
        sign: 1 ahead, -1 backwards.
        distance: [m]
        speed: [m/s]
    """

    action: str
    kind: str
    sign: float
    distance: float
    speed: float


async def _move_straight(
    ctx: ActionContext,
    robot: Actor,
    motion: _Straight,
    time_limit: float,
    namespace: str,
    *,
    check_collisions: bool,
) -> None:
    distance, speed = motion.distance, motion.speed
    for name, value in (("distance", distance), ("speed", speed)):
        if not 0.0 < value < math.inf:
            raise ActionFailed(f"invalid `{name}`: expected more than 0, found {value:g}")
    if ctx.is_home(robot, DrivenRobots):
        refuse_unless(namespace_override=(namespace, ""))
        await _drive(ctx, robot, motion.sign * speed, 0.0, distance / speed, time_limit)
        return
    limits = _limits(time_limit, check_collisions=check_collisions)
    goal = {"target": {"x": distance}, "speed": speed, **limits}
    await run_goal(ctx, full_name(robot, namespace, motion.action), motion.kind, goal)


def _limits(time_limit: float, *, check_collisions: bool) -> Members:
    # Before Kilted, the member is missing, and collisions are always checked.
    unchecked = {} if check_collisions else {"disable_collision_checks": True}
    return {"time_allowance": duration(time_limit), **unchecked}


async def _drive(
    ctx: ActionContext, robot: Actor, linear: float, angular: float, length: float, limit: float
) -> None:
    if length > limit:
        raise ActionFailed(f"the motion takes {length:g} s, longer than its `time_limit` of {limit:g} s")
    robots, name = ctx.home(robot, DrivenRobots)
    start = partial(robots.drive, name, linear, angular, length)
    await pursue(ctx, robot, BASE, start, robots.cancel_goal)
