"""Friction of the floor in MuJoCo."""

from __future__ import annotations

from sim_nodes.terrain.ground import FLOOR_FRICTION

LOOSE_PRIORITY = 2  # of geoms that slide or roll on anything, such as casters
GROUND_PRIORITY = 1  # of a floor with other friction than usual


def ground_priority(friction: float) -> int:
    """Return the priority of a geom of the floor with a friction.

    Without priority, a contact has the larger friction of the two, which would be that of the wheels.
    """
    return 0 if friction == FLOOR_FRICTION else GROUND_PRIORITY
