"""Checks of the places of robots in a world: in its extent, and not in one another."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

from sim_nodes.files import FileError
from sim_nodes.physics import PlacedRobot

FIXED = 0.05  # [m]; the radius about its origin that a robot which is fixed takes at least
TOUCH = 1e-3  # [m] that circles about robots may overlap
STOREY = 0.3  # [m] between the heights of robots from which they are above one another


def check_places(robots: Sequence[PlacedRobot], extent: tuple[float, float, float, float]) -> None:
    """Check where the robots of a world are placed.

    Args:
        robots: In the order of the world file.
        extent: Lower x, lower y, upper x, upper y of the map [m].

    Raises:
        FileError: One is outside of the map, or in another; begins with its place in the file.
    """
    left, lower, right, upper = extent
    for index, robot in enumerate(robots):
        x, y = robot.pose.x, robot.pose.y
        if not (left <= x <= right and lower <= y <= upper):
            raise FileError(
                f"robots.{index}.pose: {robot.name!r} is at x {x:g} m, y {y:g} m, outside of the world; expected "
                f"x from {left:g} m to {right:g} m, and y from {lower:g} m to {upper:g} m"
            )
    for (_, one), (index, other) in combinations(enumerate(robots), 2):
        needed, distance = _radius(one) + _radius(other), one.pose.distance(other.pose.x, other.pose.y)
        if distance < needed - TOUCH and abs(one.height - other.height) < STOREY:
            raise FileError(
                f"robots.{index}.pose: {other.name!r} is {distance:.3f} m from {one.name!r}; expected "
                f"{needed:.3f} m or more, so that they do not overlap"
            )


def _radius(robot: PlacedRobot) -> float:
    mobile = robot.declaration.mobile
    return FIXED if mobile is None else mobile.radius
