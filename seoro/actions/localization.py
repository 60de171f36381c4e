"""Actions of `osc.localization`: robots that localize themselves."""

from __future__ import annotations

from functools import partial

from seoro.actions.nav2_localization import wait_until_localized
from seoro.actions.nav2_requests import call_service
from seoro.actions.reports import finish
from seoro.actions.ros_robots import full_name, observed_names
from seoro.errors import ActionFailed
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.robots import LocalisedRobots
from seoro.runtime.contracts.ros2 import ObservedSystem, Ros2System
from seoro.runtime.functions.actions import action
from seoro.runtime.values.values import Actor


@action("differential_drive_robot.reinitialize_global_localization", home=LocalisedRobots | Ros2System)
async def reinitialize_global_localization(ctx: ActionContext, robot: Actor) -> None:
    """Discard the robot's pose estimate."""
    if not ctx.is_home(robot, LocalisedRobots):
        name = full_name(robot, "", "reinitialize_global_localization")
        await call_service(ctx, name, "std_srvs/srv/Empty", {})
        return
    robots, name = ctx.home(robot, LocalisedRobots)
    await ctx.ask(robots.reinitialize_global_localization(name))


@action("differential_drive_robot.wait_for_localization", home=LocalisedRobots | ObservedSystem)
async def wait_for_localization(ctx: ActionContext, robot: Actor) -> None:
    """Wait until the robot has localized itself."""
    if not ctx.is_home(robot, LocalisedRobots):
        system, name = ctx.home(robot, ObservedSystem)
        names = observed_names(robot, system, name)
        await wait_until_localized(ctx, system, names.full(names.pose))
        return
    robots, name = ctx.home(robot, LocalisedRobots)
    await finish(ctx, partial(robots.watch_localization, name), robots.cancel_watch)


@action("differential_drive_robot.check_localization", home=LocalisedRobots)
async def check_localization(ctx: ActionContext, robot: Actor, max_error: float) -> None:
    """Fail unless the robot has localized itself, within an error."""
    robots, name = ctx.home(robot, LocalisedRobots)
    error = await ctx.ask(robots.localization_error(name))
    if error is None:
        raise ActionFailed(f"{name} is not localized")
    if error > max_error:
        raise ActionFailed(
            f"{name} is {error:.3f} m from its estimated position; expected at most {max_error:g} m"
        )
