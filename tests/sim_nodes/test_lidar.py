from __future__ import annotations

import math

import numpy as np
import pytest

from sim_nodes.check.bench import LIDAR
from sim_nodes.noise import Noise
from sim_nodes.physics import BodyModel, BodyState, Box, Engine, Part
from sim_nodes.sensors.lidar import Lidar, Scan
from sim_nodes.worlds.loader import load_world, parse_world
from tests.sim_nodes.engines import make_engine

ROBOT = "turtlebot4"
EXACT = LIDAR.model_copy(update={"noise": 0.0})
ROOM = """
name: room
extent: [-3, -3, 3, 3]
walls: [{points: [[-2, -1], [2, -1], [2, 1], [-2, 1], [-2, -1]]}]
robots: [{name: turtlebot4, robot: turtlebot4}]
"""


def engine_with(world: str) -> Engine:
    engine = make_engine("mujoco")
    engine.build((parse_world(world, "test") if "\n" in world else load_world(world)).scene)
    for _ in range(50):
        engine.step()
    return engine


def scan(engine: Engine, tick: int = 0, declaration: object = EXACT) -> Scan:
    assert isinstance(declaration, type(LIDAR))
    return Lidar(declaration, Noise(0, "lidar"), ROBOT, engine).read(tick)


def test_beams_without_a_hit_are_infinite() -> None:
    seen = scan(engine_with("empty"))
    assert not seen.hit.any()
    assert np.isinf(seen.ranges).all()
    assert np.isinf(seen.x).all()


def test_a_spawned_box_is_seen_where_it_is() -> None:
    engine = engine_with("empty")
    engine.add_body("box", BodyModel((Part(Box((0.3, 0.3, 0.3))),)), BodyState((1.0, 0.5, 0.15)))
    seen = scan(engine)
    x, y = seen.x[seen.hit], seen.y[seen.hit]
    assert len(x) > 5
    assert np.all((x > 0.84) & (x < 1.16) & (y > 0.34) & (y < 0.66))


def test_noise_depends_on_the_tick() -> None:
    engine = engine_with(ROOM)
    first, again, later = (scan(engine, tick, LIDAR).ranges for tick in (5, 5, 6))
    np.testing.assert_array_equal(first, again)
    assert float(np.std(first - later)) == pytest.approx(LIDAR.noise * math.sqrt(2), rel=0.2)


def test_ranges_are_multiples_of_the_resolution() -> None:
    engine = engine_with(ROOM)
    ranges = scan(engine, declaration=LIDAR.model_copy(update={"resolution": 0.05})).ranges
    steps = ranges / 0.05
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)
    assert np.abs(ranges - scan(engine).ranges).max() < 0.08


def test_dropout_loses_beams_and_leaves_others_unchanged() -> None:
    engine = engine_with(ROOM)
    whole = scan(engine, 3, LIDAR).ranges
    lossy = scan(engine, 3, LIDAR.model_copy(update={"dropout": 0.25})).ranges
    lost = np.isinf(lossy)
    assert lost.mean() == pytest.approx(0.25, abs=0.08)
    np.testing.assert_array_equal(lossy[~lost], whole[~lost])
