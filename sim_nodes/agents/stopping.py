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
    apart = around.other_positions - around.positions[:, None]
    distance = np.maximum(np.hypot(apart[..., 0], apart[..., 1]), TINY)
    towards = apart / distance[..., None]
    own = (velocities[:, None] * towards).sum(axis=2)
    approach = own - (around.other_velocities * towards).sum(axis=2)
    limit = (distance - around.radii[:, None] - around.other_radii - GAP).clip(0.0) / REACTION
    excess = np.minimum(approach - limit, own)  # no walking back
    excess[around.is_self] = 0.0
    worst = excess.argmax(axis=1)
    rows = np.arange(len(worst))
    slowed: Array = velocities - towards[rows, worst] * excess[rows, worst].clip(0.0)[:, None]
    return slowed


def without_blocked(velocity: Array, points: Sequence[ContactPoint]) -> Array:
    """Return a velocity of shape (2,) without its parts into contacts [m/s]."""
    for point in points:
        normal = np.array(point.normal[:2])
        if abs(point.normal[2]) < LEVEL and (into := float(velocity @ normal)) > 0.0:
            velocity = velocity - into * normal / (normal @ normal)
    return velocity
