"""Actions of `osc.driving`: robots that are driven by velocities."""

from __future__ import annotations

from functools import partial

from seoro.actions.goals import pursue
from seoro.actions.nav2 import BASE
from seoro.runtime.actions import action
from seoro.runtime.capabilities import DrivenRobots
from seoro.runtime.context import ActionContext
from seoro.runtime.values import Actor


@action("differential_drive_robot.drive", home=DrivenRobots, uses=BASE)
async def drive(ctx: ActionContext, robot: Actor, linear: float, angular: float, duration: float) -> None:
    """Drive with a velocity for a duration; the robot stops at its end, and when this is cancelled."""
    robots, name = ctx.home(robot, DrivenRobots)
    start = partial(robots.drive, name, linear, angular, duration)
    await pursue(ctx, robot, BASE, start, robots.cancel_goal)
