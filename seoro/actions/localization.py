"""Actions of `osc.localization`: robots that find out where they are."""

from __future__ import annotations

from functools import partial

from seoro.actions.reports import finish
from seoro.errors import ActionFailed
from seoro.runtime.actions import action
from seoro.runtime.capabilities import LocalisedRobots
from seoro.runtime.context import ActionContext
from seoro.runtime.values import Actor


@action("differential_drive_robot.reinitialize_global_localization", home=LocalisedRobots)
async def reinitialize_global_localization(ctx: ActionContext, robot: Actor) -> None:
    """Forget where the robot is."""
    robots, name = ctx.home(robot, LocalisedRobots)
    await ctx.ask(robots.reinitialize_global_localization(name))


@action("differential_drive_robot.wait_for_localization", home=LocalisedRobots)
async def wait_for_localization(ctx: ActionContext, robot: Actor) -> None:
    """Wait until the robot knows where it is."""
    robots, name = ctx.home(robot, LocalisedRobots)
    await finish(ctx, partial(robots.watch_localization, name), robots.cancel_watch)


@action("differential_drive_robot.check_localization", home=LocalisedRobots)
async def check_localization(ctx: ActionContext, robot: Actor, max_error: float) -> None:
    """Fail unless the robot knows where it is."""
    robots, name = ctx.home(robot, LocalisedRobots)
    error = await ctx.ask(robots.localization_error(name))
    if error is None:
        raise ActionFailed(f"{name} does not know where it is")
    if error > max_error:
        raise ActionFailed(
            f"{name} is {error:.3f} m from where it believes to be, which is more than {max_error:g} m"
        )
