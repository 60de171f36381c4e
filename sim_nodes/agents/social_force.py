"""Social force model of Helbing and Molnar (Phys. Rev. E 51, 4282, 1995), equations (2) to (10).

A person accelerates to the wanted velocity within a relaxation time. Potentials push it away: V exp(-b / S) of
others, and U exp(-d / R) of walls at the distance d. Here b is the semi-minor axis of an ellipse along the motion
of the other one: 2 b = sqrt((|r| + |r - s|)^2 - |s|^2). The vector r leads from the other one to the person, and s
is the way of the other one in the time of a stride. Forces from outside of the field of view are weaker.

The model has points of 0.25 m radius; other radii shift the distances. Attractions and fluctuations are omitted.
"""

from __future__ import annotations

import math

import numpy as np

from sim_nodes.agents.neighbourhood import Neighbourhood
from sim_nodes.geometry import Array

RELAXATION = 0.5  # [s]
OTHERS_STRENGTH, OTHERS_RANGE = 2.1, 0.3  # V [m^2/s^2] and S [m]
WALLS_STRENGTH, WALLS_RANGE = 10.0, 0.2  # U [m^2/s^2] and R [m]
STRIDE = 2.0  # [s]
VIEW = math.cos(math.radians(100.0))  # cosine of half the field of view
UNSEEN = 0.5  # share of the forces from outside of the field of view
FASTEST = 1.3  # maximum speed, as a share of the wanted one
USUAL_RADIUS = 0.25  # [m]
TINY = 1e-9


def velocities_after(around: Neighbourhood, wanted: Array, duration: float) -> Array:
    """Return the velocities of people after a duration [s], shape (n, 2) [m/s].

    Args:
        around: The people and their neighbourhood.
        wanted: Wanted velocities, shape (n, 2) [m/s].
        duration: Duration [s].
    """
    away, radii = around.away, around.radii
    # The force of a wall is the gradient of its potential.
    distances = around.wall_distances - (radii - USUAL_RADIUS)
    strength = WALLS_STRENGTH / WALLS_RANGE * np.exp(-distances / WALLS_RANGE)
    push = strength[:, None] * away + _from_others(around, wanted)
    velocities = around.velocities + duration * ((wanted - around.velocities) / RELAXATION + push)
    limit = FASTEST * np.hypot(wanted[:, 0], wanted[:, 1])
    speed = np.hypot(velocities[:, 0], velocities[:, 1])
    limited: Array = velocities * np.minimum(1.0, limit / np.maximum(speed, TINY))[:, None]
    return limited


def _from_others(around: Neighbourhood, wanted: Array) -> Array:
    """Return the accelerations away from others, shape (n, 2) [m/s^2]."""
    # Matrices have a row for each other one and a column for each person. Sums over rows keep their order.
    apart_x, apart_y = around.positions.T[:, None] - around.other_positions.T[:, :, None]
    way_x, way_y = STRIDE * around.other_velocities.T[:, :, None]
    ahead_x, ahead_y = apart_x - way_x, apart_y - way_y
    near = np.maximum(np.hypot(apart_x, apart_y), TINY)
    far = np.maximum(np.hypot(ahead_x, ahead_y), TINY)
    total = near + far
    axis = np.sqrt(np.maximum(total * total - (way_x * way_x + way_y * way_y), TINY)) / 2.0
    excess = around.radii + around.other_radii[:, None] - 2.0 * USUAL_RADIUS
    size = OTHERS_STRENGTH / OTHERS_RANGE * np.exp((excess - axis) / OTHERS_RANGE) * total / (4.0 * axis)
    size[around.is_self.T] = 0.0
    x, y = size * (apart_x / near + ahead_x / far), size * (apart_y / near + ahead_y / far)
    heading_x, heading_y = (wanted / np.maximum(np.hypot(wanted[:, 0], wanted[:, 1]), TINY)[:, None]).T
    is_unseen = -(x * heading_x + y * heading_y) < VIEW * np.hypot(x, y)
    share = np.where(is_unseen, UNSEEN, 1.0)
    return np.array(((x * share).sum(axis=0), (y * share).sum(axis=0))).T
