from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from seoro.bridges.ros2.geometry import orientation, seconds, stamp
from seoro.robotics.geometry import Quaternion, quaternion
from seoro.robotics.transform import rotate
from sim_nodes.geometry import quaternion as reference
from sim_nodes.geometry import rotation_matrix

ANGLE = st.floats(-math.pi, math.pi)


@given(ANGLE, ANGLE, ANGLE)
def test_rotations_equal_those_of_simulators(roll: float, pitch: float, yaw: float) -> None:
    ours = quaternion(roll, pitch, yaw)
    matrix = rotation_matrix(reference(roll, pitch, yaw))
    for axis in np.eye(3):
        assert rotate(ours, (axis[0], axis[1], axis[2])) == pytest.approx(tuple(matrix @ axis), abs=1e-9)


@given(ANGLE, st.floats(-1.5, 1.5), ANGLE, st.floats(0.1, 10.0))
def test_quaternions_of_any_length_give_the_same_angles(
    roll: float, pitch: float, yaw: float, length: float
) -> None:
    x, y, z, w = quaternion(roll, pitch, yaw)
    message = SimpleNamespace(x=x * length, y=y * length, z=z * length, w=w * length)
    angles = orientation(message)
    again = quaternion(angles.roll, angles.pitch, angles.yaw)
    assert abs(sum(a * b for a, b in zip(again, (x, y, z, w), strict=True))) == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("parts", [(0.0, 0.0, 0.0, 0.0), (math.nan, 0.0, 0.0, 1.0), (math.inf, 0.0, 0.0, 1.0)])
def test_invalid_orientations_are_refused(parts: tuple[float, float, float, float]) -> None:
    with pytest.raises(ValueError, match="invalid orientation"):
        orientation(Quaternion(*parts))


def test_stamps_are_whole_nanoseconds() -> None:
    assert stamp(1.1) == {"sec": 1, "nanosec": 100_000_000}
    assert stamp(0.9999999999) == {"sec": 1, "nanosec": 0}
    assert seconds(SimpleNamespace(**stamp(12.345))) == 12.345
