"""Axes of worlds: `world?generate.rooms.count in [3, 8]` varies a key of the world file."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Final

from seoro.bundle.worlds import check_worlds
from seoro.campaign.space.axes import Axis, Choices, Interval
from seoro.embed.options import ROS_SIMULATOR, Options
from seoro.embed.world_settings import WORLD, named_world, split_world
from seoro.errors import UsageError
from seoro.lang.lower.outside import ORIGIN
from seoro.lang.plan import PrimitiveType
from seoro.lang.source import SourceFile, Span

MOST_WORLDS: Final = 100  # that are checked before a campaign
_FORM: Final = re.compile(rf"\s*({re.escape(WORLD)}[\w.\-]+)\s+in\s+\[(.*)\]\s*")
_RANGE: Final = re.compile(r"\s*(\S+?)\s*\.\.\s*(\S+)\s*")


def world_axis(text: str) -> Axis:
    """Make the axis of a constraint on a key of the world.

    Args:
        text: Key and values: `world?KEY in [A, B]` or `world?KEY in [A..B]`, with values as in world files.

    Raises:
        UsageError: The text is invalid.
    """
    found = _FORM.fullmatch(text)
    if found is None:
        raise _invalid(text)
    path, values = found.groups()
    span = Span(SourceFile(ORIGIN, text), 0, len(text))
    bounds = _RANGE.fullmatch(values)
    if bounds is None:
        texts = tuple(dict.fromkeys(each.strip() for each in values.split(",")))
        if "" in texts:
            raise _invalid(text)
        numbers = [world_number(each) for each in texts]
        known = tuple(number for number in numbers if number is not None)
        return Choices(path, texts, known if len(known) == len(texts) else None, span)
    low, high = world_number(bounds[1]), world_number(bounds[2])
    if low is None or high is None or low > high:
        raise _invalid(text)
    is_whole = isinstance(low, int) and isinstance(high, int)
    return Interval(path, low, high, is_whole, PrimitiveType("int" if is_whole else "float"), span)


def world_number(text: str) -> float | None:
    """Return a value of a world as a number; None for other texts."""
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            pass
    return None


def check_world_axes(axes: Sequence[Axis], options: Options) -> None:
    """Check the keys and values of worlds, since each run with an invalid one would be an error.

    Values are checked in as few worlds as have each listed value and both bounds of each range.

    Args:
        axes: Axes of a campaign.
        options: Options that its runs share. Worlds of running simulators and of ROS 2 systems are not checked.

    Raises:
        UsageError: A key is unknown, or a value is invalid.
    """
    varied = [axis for axis in axes if axis.path.startswith(WORLD)]
    simulator = options.simulator
    if not varied or simulator is None or simulator.endpoint is not None or simulator.name == ROS_SIMULATOR:
        return
    values = [axis.texts if isinstance(axis, Choices) else axis.levels(2) for axis in varied]
    worlds = []
    for number in range(min(max(map(len, values)), MOST_WORLDS)):
        chosen = {axis.path: texts[number % len(texts)] for axis, texts in zip(varied, values, strict=True)}
        _, of_world = split_world({**options.overrides, **chosen})
        worlds.append(named_world(simulator.world or "", of_world))
    try:
        check_worlds(worlds)
    except UsageError as error:
        raise UsageError(f"invalid values of a world: {error.message}", error.span, help=error.help) from error


def _invalid(text: str) -> UsageError:
    return UsageError(
        f"invalid values of a world: `{text}`",
        help=f"write `{WORLD}KEY in [1, 2, 4]` or `{WORLD}KEY in [0.5..1.5]`, with values as in world files",
    )
