from __future__ import annotations

import math

import pytest

from sim_nodes.clearance import WallDistance, distance_to_body
from sim_nodes.geometry import quaternion
from sim_nodes.physics import BodyModel, BodyState, Box, Cylinder, Part, Shape, Sphere, Wall


def one(shape: Shape) -> BodyModel:
    return BodyModel((Part(shape),))


def test_the_distance_to_a_wall_is_that_to_its_nearest_face() -> None:
    walls = WallDistance(
        (Wall("a", 2.0, 0.0, math.pi / 2, 2.0, 0.2, 0.5), Wall("b", -5.0, 0.0, 0.0, 1.0, 0.1, 0.5))
    )
    assert walls.at(0.0, 0.0) == pytest.approx(1.9)
    assert walls.at(2.0, 4.0) == pytest.approx(3.0)
    assert walls.at(2.05, 0.5) == 0.0
    assert WallDistance(()).at(0.0, 0.0) == math.inf


@pytest.mark.parametrize(
    ("model", "expected"),
    [
        (one(Box((0.4, 0.2, 0.3))), 1.8),
        (one(Cylinder(0.3, 1.0)), 1.7),
        (one(Sphere(0.25)), 1.75),
        (BodyModel((Part(Sphere(0.1)), Part(Sphere(0.1), (-0.5, 0.0, 0.0)))), 1.4),
    ],
)
def test_the_distance_to_a_body_is_that_to_its_nearest_part(model: BodyModel, expected: float) -> None:
    assert distance_to_body(model, BodyState((2.0, 0.0, 0.2)), 0.0, 0.0) == pytest.approx(expected)
    assert distance_to_body(model, BodyState((0.0, 0.0, 0.2)), 0.0, 0.0) == 0.0


def test_the_distance_to_a_body_depends_on_its_orientation() -> None:
    turned = BodyState((2.0, 0.0, 0.2), quaternion(0.0, 0.0, math.pi / 2))
    assert distance_to_body(one(Box((0.4, 0.2, 0.3))), turned, 0.0, 0.0) == pytest.approx(1.9)
    lying = BodyState((2.0, 0.0, 0.3), quaternion(0.0, math.pi / 2, 0.0))
    assert distance_to_body(one(Cylinder(0.3, 1.0)), lying, 0.0, 0.0) == pytest.approx(1.5)
