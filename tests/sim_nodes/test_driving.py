"""Odometry of robots that drive; `sim_nodes.check` tests how engines execute commands."""

from __future__ import annotations

from functools import partial

import pytest

from sim_nodes.__main__ import ENGINES
from sim_nodes.check.bench import BASE
from sim_nodes.geometry import Pose2
from sim_nodes.noise import Noise
from sim_nodes.robots.kinematics import Velocity, motor_commands
from sim_nodes.sensors.base import AT_START, Odometer, Odometry
from sim_nodes.ticks import TICK
from sim_nodes.worlds.loader import load_world
from tests.sim_nodes.engines import make_engine

ROBOT = "turtlebot4"
DECLARATION = BASE


def drive(name: str, velocity: Velocity, seconds: float, seed: int = 0) -> tuple[Pose2, Odometer]:
    """Drive from rest; returns the true pose and the odometry."""
    engine = make_engine(name)
    engine.build(load_world("empty").scene)
    noise = Noise(seed, "odometry")
    odometry = Odometry(DECLARATION.drive, DECLARATION.odometry, noise, partial(engine.wheel_angles, ROBOT))
    reading = AT_START
    engine.command_wheels(ROBOT, *motor_commands(DECLARATION.drive, velocity))
    tick_steps = round(TICK * engine.steps_per_second)
    for step in range(1, round(seconds * engine.steps_per_second) + 1):
        engine.step()
        if step % tick_steps == 0:
            reading = odometry.read(step // tick_steps)
    return engine.body_state(ROBOT).planar, reading


@pytest.mark.parametrize("engine", ENGINES)
def test_odometry_measures_driven_distances(engine: str) -> None:
    pose, odometry = drive(engine, Velocity(0.3, 0.0), 10.0)
    assert odometry.travelled == pytest.approx(pose.x, rel=0.03)
    assert odometry.velocity.linear == pytest.approx(0.3, rel=0.1)


@pytest.mark.parametrize("engine", ENGINES)
def test_odometry_measures_turned_angles(engine: str) -> None:
    pose, odometry = drive(engine, Velocity(0.0, 1.0), 3.0)
    assert odometry.pose.yaw == pytest.approx(pose.yaw, abs=0.15)


def test_odometry_errors_grow_with_the_distance_and_depend_on_the_seed() -> None:
    truth, first = drive("mujoco", Velocity(0.3, 0.2), 10.0, seed=1)
    _, second = drive("mujoco", Velocity(0.3, 0.2), 10.0, seed=2)
    errors = [odometry.pose.distance(truth.x, truth.y) for odometry in (first, second)]
    assert all(0.002 < error < 0.5 for error in errors)
    assert errors[0] != errors[1]


@pytest.mark.parametrize("engine", ENGINES)
def test_odometry_at_rest_has_no_errors(engine: str) -> None:
    _, odometry = drive(engine, Velocity(0.0, 0.0), 2.0)
    assert odometry.travelled < 1e-3
    assert odometry.pose == pytest.approx((0.0, 0.0, 0.0), abs=1e-3)
