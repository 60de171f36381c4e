"""Friction of the floor and light of a world, as parameters of its name."""

from __future__ import annotations

import numpy as np
import pytest

from sim_nodes.__main__ import ENGINES
from sim_nodes.check.bench import EXTENT, ROBOT, run
from sim_nodes.check.drives import robot_with
from sim_nodes.geometry import Pose2
from sim_nodes.physics import PlacedRobot, Scene
from sim_nodes.robots.drive_declaration import DriveKind
from sim_nodes.robots.kinematics import Velocity, motor_commands
from sim_nodes.terrain.ground import Ground
from sim_nodes.views import Lens, overview
from sim_nodes.worlds.loader import WorldError, load_world
from tests.sim_nodes.client import ROBOT as TURTLEBOT
from tests.sim_nodes.client import Client
from tests.sim_nodes.engines import make_engine, needs_pictures


def distance(engine: str, world: str) -> float:
    """Return the distance that a robot drives in a second [m]."""
    simulation = Client(world, engine=engine).simulator.simulation
    simulation.drive(TURTLEBOT, "goal", Velocity(0.3, 0.0), 1.0)
    simulation.run(1.0)
    return simulation.engine.body_state(TURTLEBOT).position[0]


@pytest.mark.parametrize("engine", ENGINES)
def test_wheels_slip_on_a_slippery_floor(engine: str) -> None:
    usual = distance(engine, "empty")
    assert distance(engine, "empty?floor.friction=0.5") == pytest.approx(usual, rel=0.02)
    assert distance(engine, "empty?floor.friction=0.02") < 0.6 * usual


@pytest.mark.parametrize("engine", ENGINES)
def test_planar_drives_slip_on_a_slippery_floor(engine: str) -> None:
    declaration = robot_with(DriveKind.OMNIDIRECTIONAL)
    assert declaration.mobile is not None
    driven = []
    for friction in (1.0, 0.02):
        made = make_engine(engine)
        placed = PlacedRobot(ROBOT, declaration, Pose2(0.0, 0.0, 0.0))
        made.build(Scene((), (placed,), EXTENT, Ground(friction)))
        made.command_wheels(ROBOT, *motor_commands(declaration.mobile.drive, Velocity(0.0, 0.0, 0.3)))
        run(made, 0.5)
        driven.append(made.body_state(ROBOT).position[1])
    assert driven[0] > 0.1
    assert driven[1] < 0.5 * driven[0]


@pytest.mark.parametrize("engine", ENGINES)
def test_light_changes_pictures_only(engine: str) -> None:
    needs_pictures(engine)
    made = make_engine(engine)
    seen, depths = [], []
    for parameters in ("", "?light.brightness=0.5&light.ambient=0.5"):
        scene = load_world(f"empty{parameters}").scene
        made.build(scene)
        view = overview(scene.extent, 0.5, Lens(width=32, height=24))
        seen.append(made.render(view).mean())
        depths.append(made.render_depth(view).depths)
    assert 0.2 * seen[0] < seen[1] < 0.45 * seen[0]
    assert np.array_equal(depths[0], depths[1])


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        ("floor.friction=-1", "floor.friction: .*greater than or equal to 0"),
        ("light.brightness=7", "light.brightness: .*less than or equal to 3"),
        ("light.sun=1", "light.sun: unknown key"),
    ],
)
def test_invalid_values_are_refused(parameters: str, words: str) -> None:
    with pytest.raises(WorldError, match=words):
        load_world(f"empty?{parameters}")


def test_the_sun_is_above_the_floor() -> None:
    assert load_world("empty?light.direction.x=1").light.direction == (1.0, 0.5, -1.0)
    with pytest.raises(WorldError, match=r"expected rays at least 5 degrees downwards"):
        load_world("empty?light.direction.z=0.1")
