from __future__ import annotations

import numpy as np
import pytest

from sim_nodes.geometry import quaternion
from sim_nodes.mujoco.engine import MujocoEngine
from sim_nodes.physics import BodyModel, BodyState, Box, Cylinder, Part, Sphere, UnstablePhysics
from sim_nodes.worlds.loader import load_world

ROBOT = "turtlebot4"


@pytest.fixture
def engine() -> MujocoEngine:
    engine = MujocoEngine()
    engine.build(load_world("empty").scene)
    return engine


def thing(*parts: Part, static: bool = False) -> BodyModel:
    return BodyModel(parts, mass=2.0, static=static)


CUBE = Part(Box((0.2, 0.2, 0.2)))


def test_a_state_that_is_set_is_the_state_there_is(engine: MujocoEngine) -> None:
    engine.add_body("thing", thing(CUBE), BodyState((1.0, 1.0, 1.0)))
    wanted = BodyState((2.0, -1.0, 1.5), quaternion(0.3, 0.2, 0.1), (0.1, 0.2, 0.3), (1.0, 2.0, 3.0))
    engine.set_body_state("thing", wanted)
    found = engine.body_state("thing")
    assert found.position == wanted.position
    for name in ("orientation", "linear", "angular"):
        np.testing.assert_allclose(getattr(found, name), getattr(wanted, name), atol=1e-12)


def test_a_body_falls_as_far_as_gravity_takes_it(engine: MujocoEngine) -> None:
    engine.add_body("thing", thing(CUBE), BodyState((1.0, 1.0, 2.0)))
    for _ in range(50):
        engine.step()
    assert engine.body_state("thing").position[2] == pytest.approx(2.0 - 9.81 * 0.2**2 / 2, abs=5e-3)


@pytest.mark.parametrize("shape", [Box((0.2, 0.2, 0.2)), Cylinder(0.1, 0.2), Sphere(0.1)])
def test_overlaps_are_found_for_every_shape(engine: MujocoEngine, shape: Box | Cylinder | Sphere) -> None:
    for static in (False, True):
        engine.add_body("thing", thing(Part(shape), static=static), BodyState((0.1, 0.0, 0.15)))
        assert engine.overlaps("thing") == (ROBOT,)
        engine.set_body_state("thing", BodyState((0.5, 0.0, 0.15)))
        assert engine.overlaps("thing") == ()
        engine.remove_body("thing")


def test_touching_names_pairs_once_and_leaves_the_floor_out(engine: MujocoEngine) -> None:
    engine.add_body("a", thing(CUBE), BodyState((1.0, 1.0, 0.1)))
    engine.add_body("b", thing(CUBE), BodyState((1.0, 1.0, 0.3)))
    for _ in range(100):
        engine.step()
    assert engine.touching() == {("a", "b")}


def test_a_reset_takes_everything_back_to_where_it_was_added(engine: MujocoEngine) -> None:
    engine.add_body("thing", thing(CUBE), BodyState((1.0, 1.0, 1.0)))
    engine.command_wheels(ROBOT, 5.0, 5.0)
    for _ in range(100):
        engine.step()
    engine.reset()
    assert engine.body_state("thing").position == (1.0, 1.0, 1.0)
    assert engine.body_state(ROBOT).planar == (0.0, 0.0, 0.0)
    for _ in range(100):
        engine.step()
    assert engine.body_state(ROBOT).planar.distance(0.0, 0.0) < 1e-3


def test_lost_physics_are_not_passed_over(engine: MujocoEngine, caplog: pytest.LogCaptureFixture) -> None:
    engine.add_body("thing", thing(CUBE), BodyState((1.0, 1.0, 1.0), linear=(1e300, 0.0, 0.0)))
    engine.step()
    engine.set_body_state("thing", BodyState((1.0, 1.0, 1.0), linear=(1e300, 0.0, 0.0), angular=(1e300, 0.0, 0.0)))
    with pytest.raises(UnstablePhysics, match="reset the simulation"):
        engine.step()
    assert "Nan, Inf or huge value" in caplog.text
