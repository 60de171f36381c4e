"""Arm of the tests of manipulation."""

from __future__ import annotations

import numpy as np

from sim_nodes.check.arms import CHAIN, HOME
from sim_nodes.geometry import Array
from sim_nodes.manipulation.chain import pose_matrix

__all__ = ["CHAIN", "HOME", "configurations", "downward"]


def configurations(count: int, seed: int = 0) -> Array:
    """Draw configurations within half a turn of each joint, shape (count, 6)."""
    return np.random.default_rng(seed).uniform(-3.0, 3.0, size=(count, len(HOME)))


def downward(x: float, y: float, z: float, yaw: float = 0.0) -> Array:
    """Return the pose of a tool that points down, in the arm's base."""
    cos, sin = np.cos(yaw), np.sin(yaw)
    return pose_matrix((x, y, z), np.array([[cos, sin, 0.0], [sin, -cos, 0.0], [0.0, 0.0, -1.0]]))
