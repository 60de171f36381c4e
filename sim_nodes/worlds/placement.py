"""Checks the initial poses of robots: inside the extent of the world, and outside of other things."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from seoro.bridges.wire import WorldResult
from seoro.bridges.wire.refusal import RequestRefused, name_list
from seoro.files.yaml_lines import FileError
from sim_nodes.physics import Engine, PlacedRobot

FIXED = 0.05  # [m] minimum radius about the origin of a fixed robot
TOUCH = 1e-3  # [m] by which circles about robots may overlap
STOREY = 0.3  # [m] minimum difference of heights between robots above each other


def check_placement(robots: Sequence[PlacedRobot], extent: tuple[float, float, float, float]) -> None:
    """Check the initial poses of the robots of a world.

    Args:
        robots: Robots in the order of the world file.
        extent: Lower x, lower y, upper x, upper y of the map [m].

    Raises:
        FileError: A robot is outside of the map or overlaps another; the message begins with its key in the file.
    """
    left, lower, right, upper = extent
    for index, robot in enumerate(robots):
        x, y = robot.pose.x, robot.pose.y
        if not (left <= x <= right and lower <= y <= upper):
            raise FileError(
                f"robots.{index}.pose: {robot.name!r} at x {x:g} m, y {y:g} m is outside of the world; expected "
                f"x from {left:g} to {right:g} m and y from {lower:g} to {upper:g} m"
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


def check_start_poses(engine: Engine, world: str, robots: Sequence[PlacedRobot]) -> None:
    """Check that robots do not start inside walls, props or one another.

    The base of a fixed robot is ignored: it may be sunk into its pedestal.

    Args:
        engine: Engine with the world in its initial state.
        world: Name of the world.
        robots: Robots of the world.

    Raises:
        RequestRefused: A robot overlaps something; the message names both and the pose.
    """
    for robot in robots:
        found = _overlaps(engine, robot)
        if found:
            where = f"x {robot.pose.x:g} m, y {robot.pose.y:g} m"
            raise RequestRefused(
                WorldResult.RESOURCE_PARSE_ERROR,
                f"{world}: the robot {robot.name!r} at {where} overlaps {name_list(found)}; "
                "expected a `pose` at which nothing overlaps it",
            )


def _overlaps(engine: Engine, robot: PlacedRobot) -> tuple[str, ...]:
    """Return the names of the entities that a robot overlaps, sorted."""
    arm = robot.declaration.arm
    if not robot.declaration.fixed:
        return engine.overlaps(robot.name)
    if arm is None:
        return ()
    home = np.array([joint.home for joint in arm.joints])
    return tuple(sorted({overlap.other for overlap in engine.arm_overlaps(robot.name, home, (), None)}))
