"""Actions of `osc.worlds`: named poses of the simulated world, and worlds with other values of keys."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from urllib.parse import quote

from seoro.actions.nav2_goals import drive_through
from seoro.actions.nav2_requests import BASE
from seoro.errors import ActionFailed
from seoro.files.world_names import WorldName
from seoro.lang.frozen import Value
from seoro.robotics.geometry import Pose3D
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.robots import MobileRobots
from seoro.runtime.contracts.worlds import NamedPoses, Worlds
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


class Number(Value):
    """A key of a world file, and a number in SI units."""

    key: str
    value: float


class Count(Value):
    """A key of a world file, and a whole number."""

    key: str
    value: int


class Switch(Value):
    """A key of a world file, and whether it is on."""

    key: str
    value: bool


Setting = Count | Number | Switch


@action("load_world_with", anywhere=Worlds, uris=("uri",))
async def load_world_with(
    ctx: ActionContext,
    uri: str,
    counts: Sequence[Count],
    lengths: Sequence[Number],
    masses: Sequence[Number],
    speeds: Sequence[Number],
    angles: Sequence[Number],
    times: Sequence[Number],
    numbers: Sequence[Number],
    switches: Sequence[Switch],
) -> None:
    """Continue in a world with other values of keys."""
    settings: tuple[Setting, ...] = (*counts, *lengths, *masses, *speeds, *angles, *times, *numbers, *switches)
    name = WorldName.parse(uri)
    given = [name.parameters] if name.parameters else []
    world = WorldName(name.world, "&".join((*given, *_parameters(settings))))
    await ctx.ask(ctx.anywhere(Worlds).change_world(str(world)))


def _parameters(settings: Sequence[Setting]) -> Iterator[str]:
    """Yield the settings as parameters of the name of a world."""
    keys = [setting.key for setting in settings]
    for setting in settings:
        if keys.count(setting.key) > 1:
            raise ActionFailed(f"duplicate key '{setting.key}' of a world; expected one value for each key")
        value = str(setting.value).lower() if isinstance(setting.value, bool) else repr(setting.value)
        yield f"{quote(setting.key)}={value}"
