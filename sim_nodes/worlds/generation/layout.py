"""Layouts: what generators make, before clutter and checks."""

from __future__ import annotations

import numpy as np

from seoro.deferred import dataclass
from sim_nodes.buildings.schema import DoorFile
from sim_nodes.geometry import Pose2
from sim_nodes.physics import Wall

START, GOAL = "start", "goal"
WALLS = "walls"  # entity of the walls

Extent = tuple[float, float, float, float]
Cells = tuple[int, int, int, int]  # first column, first row, and those after the last


@dataclass(frozen=True)
class Mark:
    """A named pose of a layout."""

    name: str
    pose: Pose2
    tags: tuple[str, ...] = ()


@dataclass(frozen=True)
class Dimensions:
    """Height and thickness of walls [m]."""

    height: float
    thickness: float


@dataclass(frozen=True)
class Layout:
    """Walls, named poses and doors; `extent` is lower x, lower y, upper x, upper y [m]."""

    extent: Extent
    walls: tuple[Wall, ...]
    marks: tuple[Mark, ...]
    doors: tuple[DoorFile, ...] = ()


class NoLayout(Exception):
    """A draw gave no valid layout; the message has the reason."""


def segment(start: tuple[float, float], end: tuple[float, float], of: Dimensions, name: str = WALLS) -> Wall:
    """Return a wall along a segment parallel to an axis, longer by its thickness, which closes corners [m]."""
    (ax, ay), (bx, by) = start, end
    length, thickness = abs(bx - ax) + of.thickness, abs(by - ay) + of.thickness
    return Wall(name, (ax + bx) / 2, (ay + by) / 2, 0.0, length, thickness, of.height)


def outer_walls(extent: Extent, of: Dimensions) -> tuple[Wall, ...]:
    """Return the four walls around a rectangle."""
    left, bottom, right, top = extent
    return (
        segment((left, bottom), (right, bottom), of),
        segment((left, top), (right, top), of),
        segment((left, bottom), (left, top), of),
        segment((right, bottom), (right, top), of),
    )


def about_origin(width: float, depth: float) -> Extent:
    """Return the extent of a rectangle about the origin [m]."""
    return -width / 2, -depth / 2, width / 2, depth / 2


def widened(extent: Extent, by: float) -> Extent:
    """Return an extent with a margin on each side [m]."""
    left, bottom, right, top = (round(float(value), 6) for value in np.add(extent, (-by, -by, by, by)))
    return left, bottom, right, top
