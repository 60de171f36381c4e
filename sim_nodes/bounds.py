"""How far entities reach: boxes along the axes of their own frames."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from sim_nodes.extents import reach
from sim_nodes.geometry import Array, conjugate, multiply, rotated, rotation_matrix
from sim_nodes.physics import BodyState, Engine, Part, PlacedRobot
from sim_nodes.robots.shapes import link_parts


@dataclass(frozen=True)
class BoundingBox:
    """A box along the axes of a frame by two of its corners, each of shape (3,) [m]."""

    lower: Array
    upper: Array


def bounding_box(parts: Iterable[Part]) -> BoundingBox | None:
    """The smallest box that holds all parts, in their frame; None if there are none."""
    boxes = [_box(part) for part in parts]
    if not boxes:
        return None
    lower = np.min([box.lower for box in boxes], axis=0)
    return BoundingBox(lower, np.max([box.upper for box in boxes], axis=0))


def _box(part: Part) -> BoundingBox:
    # The rows of the rotation are the axes of the body in the frame of the part.
    half = np.array([reach(part.shape, axis) for axis in rotation_matrix(part.orientation)])
    return BoundingBox(np.array(part.position) - half, np.array(part.position) + half)


def parts_of_robot(engine: Engine, robot: PlacedRobot, base: BodyState) -> Iterator[Part]:
    """What collides of a robot as it is now, in the frame of its base."""
    back = conjugate(base.orientation)
    for link, parts in link_parts(robot.declaration).items():
        if not parts:
            continue
        position, orientation = engine.link_pose(robot.name, link)
        x, y, z = rotated(back, tuple(np.subtract(position, base.position).tolist()))
        turn = multiply(back, orientation)
        for part in parts:
            dx, dy, dz = rotated(turn, part.position)
            yield Part(part.shape, (x + dx, y + dy, z + dz), multiply(turn, part.orientation))
