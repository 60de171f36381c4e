"""Transforms for tests."""

import math
from typing import Any

import numpy as np
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from seoro.bridges.ros2.tf import Transform

SECOND = 1_000_000_000  # [ns]


def at(x: float, y: float = 0.0, z: float = 0.0, yaw: float = 0.0) -> Transform:
    """Return a transform with a translation [m] and a rotation about z [rad]."""
    return Transform((x, y, z), (0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)))


def turned(yaw: float) -> Transform:
    """Return a rotation about z [rad]."""
    return at(0.0, yaw=yaw)


def matrix(transform: Transform) -> Any:
    """Return the 4 x 4 matrix of a transform."""
    found = np.eye(4)
    found[:3, :3] = Rotation.from_quat(transform.rotation).as_matrix()
    found[:3, 3] = transform.translation
    return found


def close(one: Transform, other: Transform) -> bool:
    """Return whether two transforms are equal within rounding."""
    return math.dist(one.translation, other.translation) < 1e-6 and angle(one, other) < 1e-6


def angle(one: Transform, other: Transform) -> float:
    """Return the angle between the axes of two frames, from 0 to pi [rad]."""
    return float((Rotation.from_quat(one.rotation).inv() * Rotation.from_quat(other.rotation)).magnitude())


@st.composite
def transforms(draw: st.DrawFn) -> Transform:
    """Return a strategy for transforms within 100 m."""
    numbers = st.floats(-1, 1)
    vector = np.array([draw(numbers) for _ in range(4)])
    length = float(np.linalg.norm(vector))
    rotation = vector / length if length > 0.1 else np.array([0.0, 0.0, 0.0, 1.0])
    x, y, z, w = (float(part) for part in rotation)
    distance = st.floats(-100, 100)
    return Transform((draw(distance), draw(distance), draw(distance)), (x, y, z, w))
