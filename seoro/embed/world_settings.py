"""Values of keys of the world among the overrides of a run, such as `world?generate.rooms.count=3`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Final
from urllib.parse import quote

from seoro.errors import UsageError
from seoro.files.world_names import SEPARATOR, WorldName

if TYPE_CHECKING:
    from seoro.embed.options import Options

WORLD: Final = f"world{SEPARATOR}"  # before the key


def split_world(overrides: Mapping[str, str]) -> tuple[dict[str, str], dict[str, str]]:
    """Split overrides into those of parameters and those of keys of the world."""
    of_world = {path: text for path, text in overrides.items() if path.startswith(WORLD)}
    return {path: text for path, text in overrides.items() if path not in of_world}, of_world


def constraints_of_scenario(constraints: Iterable[str]) -> tuple[str, ...]:
    """Return the constraints without those on keys of the world, which only campaigns have."""
    return tuple(text for text in constraints if not text.lstrip().startswith(WORLD))


def with_world(options: Options) -> Options:
    """Return options whose world has the keys that its overrides set.

    Raises:
        UsageError: Overrides or constraints name keys of a world, but the options name no world.
    """
    overrides, of_world = split_world(options.overrides)
    of_campaign = [text for text in options.constraints if text not in constraints_of_scenario([text])]
    if of_campaign:
        raise UsageError(
            f"`{of_campaign[0]}` varies a world, which only campaigns do",
            help=f"set a value: `--set '{WORLD}KEY=VALUE'`",
        )
    if not of_world:
        return options
    simulator = options.simulator
    if simulator is None or simulator.world is None:
        raise UsageError(
            f"`{next(iter(of_world))}` needs the name or the file of a world",
            help="add `--sim mujoco --world office`",
        )
    world = named_world(simulator.world, of_world)
    return replace(options, overrides=overrides, simulator=replace(simulator, world=world))


def named_world(world: str, values: Mapping[str, str]) -> str:
    """Return the name of a world with other values of its keys.

    Args:
        world: Name or file of the world, perhaps with parameters.
        values: Values by key, as overrides of a run name them.
    """
    name = WorldName.parse(world)
    given = [name.parameters] if name.parameters else []
    given += [f"{quote(path.removeprefix(WORLD))}={quote(text)}" for path, text in values.items()]
    return str(WorldName(name.world, "&".join(given)))
