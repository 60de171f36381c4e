"""Actions of `osc.driving`: robots driven by velocity commands."""

from __future__ import annotations

from functools import partial

from seoro.actions.goals import pursue
from seoro.actions.nav2 import BASE
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.robots import DrivenRobots
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
