"""Actions of `osc.worlds`: named poses of the simulated world."""

from __future__ import annotations

from seoro.actions.nav2 import BASE, drive_through
from seoro.errors import ActionFailed
from seoro.robotics.geometry import Pose3D
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.robots import MobileRobots
from seoro.runtime.contracts.worlds import NamedPoses
from seoro.runtime.functions.actions import action
from seoro.runtime.values.values import Actor


@action("differential_drive_robot.init_at", home=MobileRobots, anywhere=NamedPoses)
async def init_at(ctx: ActionContext, robot: Actor, place: str) -> None:
    """Set the initial pose of a robot at a named pose of the world."""
    robots, name = ctx.home(robot, MobileRobots)
    await ctx.ask(robots.set_initial_pose(name, await _pose(ctx, place)))


@action("differential_drive_robot.nav_to_place", home=MobileRobots, anywhere=NamedPoses, uses=BASE)
async def nav_to_place(ctx: ActionContext, robot: Actor, place: str) -> None:
    """Drive to a named pose of the world."""
    await drive_through(ctx, robot, (await _pose(ctx, place),), stop_at_each=False)


async def _pose(ctx: ActionContext, place: str) -> Pose3D:
    poses = await ctx.ask(ctx.anywhere(NamedPoses).named_poses())
    if place not in poses:
        raise ActionFailed(f"unknown pose '{place}' of the world (poses: {', '.join(poses) or 'none'})")
    return poses[place]
