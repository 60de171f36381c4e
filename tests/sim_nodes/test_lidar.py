from __future__ import annotations

import math

import numpy as np
import pytest

from sim_nodes.geometry import Array
from sim_nodes.mujoco.engine import MujocoEngine
from sim_nodes.noise import Noise
from sim_nodes.physics import BodyModel, BodyState, Box, Part
from sim_nodes.robots.declaration import load_robot
from sim_nodes.sensors.lidar import Lidar, Scan
from sim_nodes.worlds.loader import load_world, parse_world

ROBOT = "turtlebot4"
LIDAR = load_robot("turtlebot4").lidar
EXACT = LIDAR.model_copy(update={"noise": 0.0})
ROOM = """
name: room
extent: [-3, -3, 3, 3]
walls: [{points: [[-2, -1], [2, -1], [2, 1], [-2, 1], [-2, -1]]}]
robots: [{name: turtlebot4, robot: turtlebot4}]
"""


def engine_with(world: str) -> MujocoEngine:
    engine = MujocoEngine()
    engine.build((parse_world(world, "test") if "\n" in world else load_world(world)).scene)
    for _ in range(50):
        engine.step()
    return engine


def scan(engine: MujocoEngine, tick: int = 0, declaration: object = EXACT) -> Scan:
    assert isinstance(declaration, type(LIDAR))
    return Lidar(declaration, Noise(0, "lidar")).scan(engine, ROBOT, tick)


def expected(angles: Array) -> Array:
    """Distances from (-0.04, 0) to the inside of a room of 3.9 by 1.9 m about the origin."""
    cos, sin = np.cos(angles), np.sin(angles)
    with np.errstate(divide="ignore"):
        to_x = np.where(cos > 0, 1.95 + 0.04, 1.95 - 0.04) / np.abs(cos)
        to_y = 0.95 / np.abs(sin)
    nearest: Array = np.minimum(to_x, to_y)
    return nearest


def test_ranges_are_those_of_the_room() -> None:
    seen = scan(engine_with(ROOM))
    assert seen.hit.all()
    np.testing.assert_allclose(seen.ranges, expected(seen.angles), atol=0.01)


def test_the_robot_does_not_see_itself_and_nothing_is_infinite() -> None:
    seen = scan(engine_with("empty"))
    assert not seen.hit.any()
    assert np.isinf(seen.x).all()


def test_a_spawned_box_is_seen_where_it_is() -> None:
    engine = engine_with("empty")
    engine.add_body("box", BodyModel((Part(Box((0.3, 0.3, 0.3))),)), BodyState((1.0, 0.5, 0.15)))
    seen = scan(engine)
    x, y = seen.x[seen.hit], seen.y[seen.hit]
    assert len(x) > 5
    assert np.all((x > 0.84) & (x < 1.16) & (y > 0.34) & (y < 0.66))


def test_noise_is_that_of_the_tick() -> None:
    engine = engine_with(ROOM)
    first, again, later = (scan(engine, tick, LIDAR).ranges for tick in (5, 5, 6))
    np.testing.assert_array_equal(first, again)
    assert float(np.std(first - later)) == pytest.approx(LIDAR.noise * math.sqrt(2), rel=0.2)
