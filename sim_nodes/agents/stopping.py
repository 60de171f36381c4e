"""Velocities that stop before walls and others, and at what an agent touches."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from sim_nodes.agents.neighbourhood import Neighbourhood
from sim_nodes.geometry import Array
from sim_nodes.physics import ContactPoint

REACTION = 0.25  # [s] in which the rest of a distance may be used up
GAP = 0.05  # [m] kept from others
LEVEL = 0.5  # vertical component of a normal from which a contact does not block
TINY = 1e-9


def stop_before_walls(around: Neighbourhood, velocities: Array) -> Array:
    """Return velocities of shape (n, 2) without the part that leads into a wall within the reaction time [m/s]."""
    limit = (around.wall_distances - around.radii).clip(0.0) / REACTION
    approach = -(velocities * around.away).sum(axis=1)
    slowed: Array = velocities + around.away * (approach - limit).clip(0.0)[:, None]
    return slowed


def stop_before_others(around: Neighbourhood, velocities: Array) -> Array:
    """Return velocities of shape (n, 2) without the part that leads into the most urgent other one [m/s]."""
    # Matrices have a row for each other one and a column for each agent.
    apart_x, apart_y = around.other_positions.T[:, :, None] - around.positions.T[:, None]
    distance = np.maximum(np.hypot(apart_x, apart_y), TINY)
    towards_x, towards_y = apart_x / distance, apart_y / distance
    own_x, own_y = velocities.T
    other_x, other_y = around.other_velocities.T[:, :, None]
    own = own_x * towards_x + own_y * towards_y
    approach = own - (other_x * towards_x + other_y * towards_y)
    limit = (distance - around.radii - around.other_radii[:, None] - GAP).clip(0.0) / REACTION
    excess = np.minimum(approach - limit, own)  # no walking back
    excess[around.is_self.T] = 0.0
    columns = np.arange(len(velocities))
    worst = excess.argmax(axis=0), columns
    slowed: Array = (
        velocities - np.array((towards_x[worst], towards_y[worst])).T * excess[worst].clip(0.0)[:, None]
    )
    return slowed


def without_blocked(velocity: Array, points: Sequence[ContactPoint]) -> Array:
    """Return a velocity of shape (2,) without its parts into contacts [m/s]."""
    for point in points:
        normal = np.array(point.normal[:2])
        if abs(point.normal[2]) < LEVEL and (into := float(velocity @ normal)) > 0.0:
            velocity = velocity - into * normal / (normal @ normal)
    return velocity
