"""Actions of `osc.driving`: robots driven by velocity commands."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from seoro.actions.goals import pursue
from seoro.actions.nav2_requests import BASE
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.people import Point
from seoro.runtime.contracts.robots import DrivenRobots, PathRobots
from seoro.runtime.functions.actions import action
from seoro.runtime.values.values import Actor


@action("differential_drive_robot.drive", home=DrivenRobots, uses=BASE)
async def drive(
    ctx: ActionContext, robot: Actor, linear: float, angular: float, duration: float, lateral: float
) -> None:
    """Drive with a velocity for a duration; the robot stops at the end and on cancellation."""
    robots, name = ctx.home(robot, DrivenRobots)
    start = partial(robots.drive, name, linear, angular, duration, lateral=lateral)
    await pursue(ctx, robot, BASE, start, robots.cancel_goal)


@action("differential_drive_robot.follow_path", home=PathRobots, uses=BASE)
async def follow_path(ctx: ActionContext, robot: Actor, positions: Sequence[Point], speed: float) -> None:
    """Drive along positions by the true pose."""
    await _follow(ctx, robot, positions, speed, repeat=False)


@action("differential_drive_robot.patrol", home=PathRobots, uses=BASE, open_ended=True)
async def patrol(ctx: ActionContext, robot: Actor, positions: Sequence[Point], speed: float) -> None:
    """Drive along positions by the true pose, again and again."""
    await _follow(ctx, robot, positions, speed, repeat=True)


async def _follow(
    ctx: ActionContext, robot: Actor, positions: Sequence[Point], speed: float, *, repeat: bool
) -> None:
    robots, name = ctx.home(robot, PathRobots)
    start = partial(robots.follow_path, name, positions, speed, repeat=repeat)
    await pursue(ctx, robot, BASE, start, robots.cancel_goal)
