"""Checks that robots start outside of walls and props, by the shapes of the engine."""

from __future__ import annotations

import numpy as np

from seoro.bridges.wire import WorldResult
from seoro.bridges.wire.refusal import RequestRefused, listed
from sim_nodes.physics import Engine, PlacedRobot
from sim_nodes.worlds.loader import World


def check_starts(engine: Engine, world: World) -> None:
    """Check that robots do not start inside walls, props or one another.

    The base of a fixed robot is left out: it may be sunk into what it is mounted on.

    Args:
        engine: Has the world, in its initial state.
        world: The world.

    Raises:
        RequestRefused: A robot overlaps something: which, where and what.
    """
    for robot in world.robots:
        found = _overlaps(engine, robot)
        if found:
            where = f"x {robot.pose.x:g} m, y {robot.pose.y:g} m"
            raise RequestRefused(
                WorldResult.RESOURCE_PARSE_ERROR,
                f"{world.name}: the robot {robot.name!r} at {where} overlaps {listed(found)}; "
                "expected a `pose` at which nothing overlaps it",
            )


def _overlaps(engine: Engine, robot: PlacedRobot) -> tuple[str, ...]:
    """Return the names of what a robot overlaps, sorted."""
    arm = robot.declaration.arm
    if not robot.declaration.fixed:
        return engine.overlaps(robot.name)
    if arm is None:
        return ()
    home = np.array([joint.home for joint in arm.joints])
    return tuple(sorted({overlap.other for overlap in engine.arm_overlaps(robot.name, home, (), None)}))
