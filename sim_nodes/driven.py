"""Velocities that keep driven bodies upright and at their height, for engines that implement `DrivesBodies`.

A driven body is a free body that does not touch the floor. Gravity and collisions move it between two ticks, so
each tick sets velocities that bring it to its height, and its axis to the vertical, until the next tick.
"""

from __future__ import annotations

import numpy as np

from sim_nodes.geometry import Array
from sim_nodes.ticks import TICK

GRAVITY = 9.81  # [m/s^2]


def upright_velocities(
    velocities: Array, climbs: Array, orientations: Array, falling: Array
) -> tuple[Array, Array]:
    """Return linear and angular velocities in the axes of `map` for the next tick, each of shape (n, 3).

    Args:
        velocities: Wanted velocities: x, y [m/s], and yaw rate [rad/s], shape (n, 3).
        climbs: Wanted change of the height of each body [m], shape (n,).
        orientations: Orientations as (w, x, y, z), shape (n, 4).
        falling: 1.0 for each body with weight, otherwise 0.0, shape (n,).
    """
    w, x, y, z = orientations.T
    # The axis (lean_x, lean_y, about 1) of the body turns to the vertical about their cross product.
    lean_x, lean_y = 2.0 * (x * z + w * y), 2.0 * (y * z - w * x)
    linear = velocities.copy()
    linear[:, 2] = climbs / TICK + falling * (GRAVITY * TICK / 2.0)
    angular = np.column_stack([lean_y / TICK, -lean_x / TICK, velocities[:, 2]])
    return linear, angular


def yaws(orientations: Array) -> Array:
    """Return the yaws of orientations as (w, x, y, z) of shape (n, 4), shape (n,) [rad]."""
    w, x, y, z = orientations.T
    angles: Array = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return angles
