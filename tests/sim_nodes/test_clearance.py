from __future__ import annotations

import math

import numpy as np
import pytest

from sim_nodes.clearance import Clearance, Search, WallDistance, distance_to_body
from sim_nodes.geometry import Pose2, quaternion
from sim_nodes.near_walls import NearWalls
from sim_nodes.physics import BodyModel, BodyState, Box, Cylinder, Part, Shape, Sphere, Wall
from tests.sim_nodes.client import ROBOT, Client, pose


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


def test_a_bound_leaves_out_entities_beyond_it() -> None:
    client = Client("maze")
    client.spawn("box", pose(1.0, 0.6, z=0.1))
    clearances = client.simulator.simulation.run_data.clearances
    for x in (-3.0, 0.3, 0.6, 2.2):
        for y in (-3.1, -1.0, 0.4, 4.0):
            here = Pose2(x, y, 0.0)
            (nearest,) = clearances.nearest([Search(ROBOT, here)])
            bounds = [nearest.distance + 1e-9, nearest.distance]
            found = clearances.nearest([Search(ROBOT, here, bound) for bound in bounds])
            assert found in ([nearest, Clearance()], [nearest, nearest])


def test_near_walls_have_the_distance_of_all_walls() -> None:
    places = np.random.default_rng(0).uniform(-4.0, 4.0, (200, 2)).tolist()
    walls = WallDistance([Wall(str(i), x, y, 0.1 * i, 1.5, 0.1, 0.5) for i, (x, y) in enumerate(places[:20])])
    for x, y in places:
        near = walls.near(x + 0.1, y - 0.1, 0.2)
        assert near.covers(x, y) and not near.covers(x + 0.3, y)
        assert Clearance(*near.nearest(x, y)) == walls.nearest(x, y)
    assert Clearance(*WallDistance(()).near(0.0, 0.0, 0.2).nearest(0.0, 0.0)) == Clearance()


def test_a_drive_seldom_needs_the_distance_to_walls(monkeypatch: pytest.MonkeyPatch) -> None:
    client, calls, near = Client("maze"), [0], WallDistance.near

    def counted(walls: WallDistance, x: float, y: float, reach: float) -> NearWalls:
        calls[0] += 1
        return near(walls, x, y, reach)

    monkeypatch.setattr(WallDistance, "near", counted)
    client.localise()
    client.navigate(pose(1.5, 1.5))
    client.run_until("goal")
    travelled = client.simulator.simulation.travelled(ROBOT)
    assert calls[0] < 0.1 * travelled / 0.01  # instead of once in each centimetre
