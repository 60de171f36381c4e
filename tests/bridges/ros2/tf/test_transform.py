"""Transforms against the same computed by matrices."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from seoro.bridges.ros2.tf import IDENTITY, Transform
from seoro.bridges.ros2.tf.transform import interpolate, normalised
from tests.bridges.ros2.tf.frames import close, matrix, transforms, turned

SHARES = st.floats(0, 1)


@given(transforms(), transforms())
def test_composition_is_that_of_matrices(outer: Transform, inner: Transform) -> None:
    assert np.allclose(matrix(outer @ inner), matrix(outer) @ matrix(inner), atol=1e-6)


@given(transforms())
def test_the_inverse_undoes(transform: Transform) -> None:
    assert np.allclose(matrix(transform.inverse()), np.linalg.inv(matrix(transform)), atol=1e-6)
    assert close(transform @ transform.inverse(), IDENTITY)


@given(transforms(), st.tuples(*[st.floats(-100, 100)] * 3))
def test_points_are_moved_as_by_matrices(transform: Transform, point: tuple[float, float, float]) -> None:
    assert np.allclose(transform.apply(point), (matrix(transform) @ [*point, 1])[:3], atol=1e-6)


@settings(max_examples=50)
@given(transforms(), transforms(), SHARES)
def test_what_lies_between_is_on_the_line_and_on_the_arc(
    before: Transform, after: Transform, share: float
) -> None:
    found = interpolate(before, after, share)
    line = np.array(before.translation) * (1 - share) + np.array(after.translation) * share
    assert np.allclose(found.translation, line, atol=1e-6)
    if before.angle_to(after) < math.pi - 1e-3:  # beyond, both ways are as short
        arc = Slerp([0, 1], Rotation.from_quat([before.rotation, after.rotation]))(share)
        assert (Rotation.from_quat(found.rotation).inv() * arc).magnitude() < 1e-5


@given(transforms(), transforms())
def test_angles_and_distances_are_those_between(one: Transform, other: Transform) -> None:
    angle = (Rotation.from_quat(one.rotation).inv() * Rotation.from_quat(other.rotation)).magnitude()
    assert one.angle_to(other) == pytest.approx(angle, abs=1e-6)
    assert one.distance_to(other) == pytest.approx(np.linalg.norm(np.subtract(one.translation, other.translation)))


@pytest.mark.parametrize("yaw", [-3.0, -1.0, 0.0, 0.5, 3.1])
def test_yaw_is_the_angle_about_z(yaw: float) -> None:
    assert turned(yaw).yaw == pytest.approx(yaw)


def test_a_quaternion_without_direction_is_none() -> None:
    assert normalised((0.0, 0.0, 0.0, 0.0)) is None
    assert normalised((math.nan, 0.0, 0.0, 1.0)) is None
    assert normalised((0.0, 0.0, 0.0, math.inf)) is None
    assert normalised((0.0, 0.0, 0.0, 2.0)) == (0.0, 0.0, 0.0, 1.0)
