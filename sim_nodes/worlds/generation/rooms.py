"""Floors of rooms: a rectangle is split by random walls, which get doors."""

from __future__ import annotations

import math
from itertools import combinations
from typing import Literal

import numpy as np

from seoro.deferred import dataclass
from sim_nodes.agents.schema import FloorPoseFile
from sim_nodes.buildings.schema import AutomaticFile, DoorFile
from sim_nodes.geometry import Pose2
from sim_nodes.physics import Wall
from sim_nodes.worlds.generation.layout import (
    GOAL,
    START,
    Dimensions,
    Extent,
    Layout,
    Mark,
    NoLayout,
    about_origin,
    outer_walls,
    segment,
    widened,
)
from sim_nodes.worlds.generation.schema import RoomsFile

JAMB = 0.1  # [m] minimum wall on each side of a door, besides the thickness of other walls
CORRIDOR = "corridor"


@dataclass(frozen=True)
class _Shared:
    """The stretch of wall between two rooms: from `low` to `high` along it, at `across` [m]."""

    rooms: tuple[int, int]
    is_vertical: bool  # along y
    across: float
    low: float
    high: float


def rooms(rooms: RoomsFile, of: Dimensions, random: np.random.Generator) -> Layout:
    """Draw rooms, with the poses `room_1`, `room_2`, ... in their middle and `door_1`, ... in doors.

    With `doors`, there are doors with the names of the latter. Rooms are numbered by y, then by x. `start` is in
    the first room, `goal` in the one most doors away.

    Args:
        rooms: Parameters.
        of: Height and thickness of the walls.
        random: Source of random numbers.

    Raises:
        NoLayout: The rooms do not fit into the rectangle, or a room has no wall for a door.
    """
    extent = about_origin(*rooms.size)
    areas, corridor = _areas(rooms, extent, random)
    shared = _shared_walls(areas)
    doors = _doors(shared, len(areas), rooms, of, random)
    walls: list[Wall] = [*outer_walls(extent, of)]
    marks: list[Mark] = []
    made: list[DoorFile] = []
    for stretch in shared:
        middle = doors.get(stretch.rooms)
        walls += _with_door(stretch, middle, rooms.door, of)
        if middle is not None:
            x, y = (stretch.across, middle) if stretch.is_vertical else (middle, stretch.across)
            yaw = 0.0 if stretch.is_vertical else math.pi / 2
            marks.append(Mark(f"door_{len(marks) + 1}", Pose2(x, y, yaw), ("door",)))
            if rooms.doors != "open":
                made.append(_door(marks[-1], stretch, middle, rooms))
    names = [CORRIDOR if index == corridor else "" for index in range(len(areas))]
    numbers = iter(range(1, len(areas) + 1))
    names = [name or f"room_{next(numbers)}" for name in names]
    inside = [Mark(name, _middle(area), ("room",)) for name, area in zip(names, areas, strict=True)]
    first = names.index("room_1")
    last = _farthest(first, list(doors), len(areas))
    ends = (Mark(START, inside[first].pose), Mark(GOAL, inside[last].pose, ("goal",)))
    return Layout(widened(extent, of.thickness), tuple(walls), (*ends, *inside, *marks), tuple(made))


def _door(mark: Mark, stretch: _Shared, middle: float, rooms: RoomsFile) -> DoorFile:
    """Return a door at a mark, which slides into the longer wall beside it, or turns if both are too short."""
    low, high = middle - stretch.low - rooms.door / 2, stretch.high - middle - rooms.door / 2
    # The left side of a door is at greater y, or at smaller x.
    side: Literal["left", "right"] = "left" if (high > low) == stretch.is_vertical else "right"
    return DoorFile(
        name=mark.name,
        pose=FloorPoseFile(x=mark.pose.x, y=mark.pose.y, yaw=mark.pose.yaw),
        kind="sliding" if max(low, high) >= rooms.door else "hinged",
        side=side,
        width=rooms.door,
        automatic=AutomaticFile() if rooms.doors == "automatic" else None,
        tags=mark.tags,
    )


def _areas(rooms: RoomsFile, extent: Extent, random: np.random.Generator) -> tuple[list[Extent], int | None]:
    """Return the rooms by y and x, and the index of the corridor."""
    left, bottom, right, top = extent
    if rooms.corridor is None:
        return sorted(_split([extent], rooms, random), key=_by_place), None
    half = rooms.corridor / 2
    corridor = (left, -half, right, half)
    sides = [(left, bottom, right, -half), (left, half, right, top)]
    if rooms.smallest > top - half:
        raise NoLayout(f"beside the corridor are {top - half:g} m; expected {rooms.smallest:g} m (`smallest`)")
    areas = sorted([*_split(sides, rooms, random), corridor], key=_by_place)
    return areas, areas.index(corridor)


def _by_place(area: Extent) -> tuple[float, float]:
    return area[1], area[0]


def _split(areas: list[Extent], rooms: RoomsFile, random: np.random.Generator) -> list[Extent]:
    """Split the largest area that can be split, along its longer edge, until there are enough."""
    while len(areas) < rooms.count:
        wide = [area for area in areas if max(_edges(area)) >= 2 * rooms.smallest]
        if not wide:
            raise NoLayout(f"{len(areas)} rooms fit into `size`; expected {rooms.count} (`count`)")
        area = max(wide, key=lambda each: math.prod(_edges(each)))
        areas.remove(area)
        areas += _halves(area, rooms.smallest, float(random.random()))
    return areas


def _edges(area: Extent) -> tuple[float, float]:
    return area[2] - area[0], area[3] - area[1]


def _halves(area: Extent, smallest: float, share: float) -> tuple[Extent, Extent]:
    left, bottom, right, top = area
    if right - left >= top - bottom:
        at = _cut(left, right, smallest, share)
        return (left, bottom, at, top), (at, bottom, right, top)
    at = _cut(bottom, top, smallest, share)
    return (left, bottom, right, at), (left, at, right, top)


def _cut(low: float, high: float, smallest: float, share: float) -> float:
    return round(low + smallest + share * (high - low - 2 * smallest), 3)


def _shared_walls(areas: list[Extent]) -> list[_Shared]:
    """Return the stretches of wall between neighbours; together they are all inner walls."""
    found = []
    for (i, one), (j, other) in combinations(enumerate(areas), 2):
        for axis in (0, 1):
            across = one[axis + 2] if one[axis + 2] == other[axis] else one[axis]
            low = max(one[1 - axis], other[1 - axis])
            high = min(one[3 - axis], other[3 - axis])
            touches = across in (other[axis], other[axis + 2]) and one[axis] != other[axis]
            if touches and high > low:
                found.append(_Shared((i, j), axis == 0, across, low, high))
    return found


def _doors(
    shared: list[_Shared], count: int, rooms: RoomsFile, of: Dimensions, random: np.random.Generator
) -> dict[tuple[int, int], float]:
    """Return the middles of doors along their walls, by rooms: a random spanning tree, and some more [m]."""
    space = rooms.door / 2 + of.thickness / 2 + JAMB
    fitting = [each for each in shared if each.high - each.low >= 2 * space]
    group = list(range(count))  # of rooms that are connected
    chosen: list[_Shared] = []
    others: list[_Shared] = []
    for index in random.permutation(len(fitting)).tolist():
        one, other = (group[room] for room in fitting[index].rooms)
        (others if one == other else chosen).append(fitting[index])
        group = [one if each == other else each for each in group]
    if len(set(group)) > 1:
        raise NoLayout("a room has no wall that is long enough for a door")
    chosen += others[: round(rooms.loops * len(others))]
    chosen.sort(key=lambda each: each.rooms)
    return {each.rooms: float(random.uniform(each.low + space, each.high - space)) for each in chosen}


def _with_door(stretch: _Shared, middle: float | None, width: float, of: Dimensions) -> list[Wall]:
    """Return the walls of a stretch on both sides of its door."""
    ends = [stretch.low, stretch.high]
    if middle is not None:
        half = (width + of.thickness) / 2  # walls are longer by their thickness
        ends = [stretch.low, middle - half, middle + half, stretch.high]
    pairs = zip(ends[::2], ends[1::2], strict=True)
    if stretch.is_vertical:
        return [segment((stretch.across, low), (stretch.across, high), of) for low, high in pairs]
    return [segment((low, stretch.across), (high, stretch.across), of) for low, high in pairs]


def _middle(area: Extent) -> Pose2:
    return Pose2((area[0] + area[2]) / 2, (area[1] + area[3]) / 2, 0.0)


def _farthest(first: int, doors: list[tuple[int, int]], count: int) -> int:
    """Return the room most doors away from the first one; the last of several."""
    away = {first: 0}
    for steps in range(1, count + 1):
        reached = {room for pair in doors for room in pair if any(away.get(each) == steps - 1 for each in pair)}
        away |= {room: steps for room in reached if room not in away}
    return max(away, key=lambda room: (away[room], room))
