from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim_nodes.geometry import (
    Pose2,
    conjugate,
    multiply,
    quaternion,
    quaternion_of,
    roll_pitch_yaw,
    rotation_matrix,
    wrap,
)

angles = st.floats(-1.5, 1.5)
lengths = st.floats(-10, 10)


@given(lengths, lengths, angles)
def test_a_pose_composed_with_its_inverse_is_the_identity(x: float, y: float, yaw: float) -> None:
    there = Pose2(x, y, yaw)
    assert there.compose(there.inverse()) == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)


def test_composing_rotates_the_inner_pose() -> None:
    assert Pose2(1.0, 2.0, math.pi / 2).compose(Pose2(3.0, 0.0, 0.5)) == pytest.approx(
        (1.0, 5.0, math.pi / 2 + 0.5)
    )


@given(angles, angles, angles)
def test_angles_survive_conversion_to_a_quaternion(roll: float, pitch: float, yaw: float) -> None:
    assert roll_pitch_yaw(quaternion(roll, pitch, yaw)) == pytest.approx((roll, pitch, yaw), abs=1e-6)


@given(angles, angles, st.sampled_from([-math.pi / 2, math.pi / 2]), st.sampled_from([0.0, 1e-9, 1e-7, 1e-5]))
def test_angles_at_gimbal_lock_give_the_same_orientation(
    roll: float, yaw: float, pitch: float, off: float
) -> None:
    orientation = quaternion(roll, pitch - math.copysign(off, pitch), yaw)
    again = quaternion(*roll_pitch_yaw(orientation))
    np.testing.assert_allclose(rotation_matrix(again), rotation_matrix(orientation), atol=1e-5)


@given(st.floats(-math.pi, math.pi), angles, st.floats(-math.pi, math.pi))
def test_matrices_match_quaternions_and_conjugates(roll: float, pitch: float, yaw: float) -> None:
    orientation = quaternion(roll, pitch, yaw)
    matrix = rotation_matrix(orientation)
    np.testing.assert_allclose(rotation_matrix(quaternion_of(matrix)), matrix, atol=1e-12)
    np.testing.assert_allclose(rotation_matrix(conjugate(orientation)), matrix.T, atol=1e-12)


@given(angles, angles, angles)
def test_yaw_is_applied_first(roll: float, pitch: float, yaw: float) -> None:
    steps = [rotation_matrix(quaternion(*each)) for each in ((0, 0, yaw), (0, pitch, 0), (roll, 0, 0))]
    np.testing.assert_allclose(
        rotation_matrix(quaternion(roll, pitch, yaw)), steps[0] @ steps[1] @ steps[2], atol=1e-9
    )


@given(angles, angles)
def test_multiplying_quaternions_multiplies_matrices(first: float, second: float) -> None:
    a, b = quaternion(first, second, 0.3), quaternion(0.1, first, second)
    np.testing.assert_allclose(rotation_matrix(multiply(a, b)), rotation_matrix(a) @ rotation_matrix(b), atol=1e-9)


def test_angles_are_wrapped() -> None:
    assert wrap(3 * math.pi) == pytest.approx(-math.pi)
    assert wrap(-0.1) == pytest.approx(-0.1)
