"""Transforms compared with matrices."""

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from seoro.bridges.ros2.tf import IDENTITY, Transform
from seoro.robotics.transform import interpolate, normalised
from tests.bridges.ros2.tf.frames import angle, close, matrix, transforms

SHARES = st.floats(0, 1)


@given(transforms(), transforms())
def test_composition_equals_that_of_matrices(outer: Transform, inner: Transform) -> None:
    assert np.allclose(matrix(outer @ inner), matrix(outer) @ matrix(inner), atol=1e-6)


@given(transforms())
def test_the_inverse_undoes_a_transform(transform: Transform) -> None:
    assert np.allclose(matrix(transform.inverse()), np.linalg.inv(matrix(transform)), atol=1e-6)
    assert close(transform @ transform.inverse(), IDENTITY)


@given(transforms(), st.tuples(*[st.floats(-100, 100)] * 3))
def test_transformed_points_equal_those_of_matrices(
    transform: Transform, point: tuple[float, float, float]
) -> None:
    assert np.allclose(transform.apply(point), (matrix(transform) @ [*point, 1])[:3], atol=1e-6)


@settings(max_examples=50)
@given(transforms(), transforms(), SHARES)
def test_interpolated_transforms_lie_on_the_line_and_the_arc(
    before: Transform, after: Transform, share: float
) -> None:
    found = interpolate(before, after, share)
    line = np.array(before.translation) * (1 - share) + np.array(after.translation) * share
    assert np.allclose(found.translation, line, atol=1e-6)
    if angle(before, after) < math.pi - 1e-3:  # beyond, both arcs are equally short
        arc = Slerp([0, 1], Rotation.from_quat([before.rotation, after.rotation]))(share)
        assert (Rotation.from_quat(found.rotation).inv() * arc).magnitude() < 1e-5


def test_invalid_quaternions_have_no_normalised_form() -> None:
    assert normalised((0.0, 0.0, 0.0, 0.0)) is None
    assert normalised((math.nan, 0.0, 0.0, 1.0)) is None
    assert normalised((0.0, 0.0, 0.0, math.inf)) is None
    assert normalised((0.0, 0.0, 0.0, 2.0)) == (0.0, 0.0, 0.0, 1.0)
