from __future__ import annotations

import math

import pytest

from sim_nodes.geometry import Pose2
from sim_nodes.mujoco.engine import MujocoEngine
from sim_nodes.noise import Noise
from sim_nodes.robots.declaration import load_robot
from sim_nodes.robots.diff_drive import Velocity, wheel_speeds
from sim_nodes.sensors.odometry import Odometry
from sim_nodes.worlds.loader import load_world

ROBOT = "turtlebot4"
DECLARATION = load_robot("turtlebot4")
TICK_STEPS = 5


def drive(velocity: Velocity, seconds: float, seed: int = 0) -> tuple[Pose2, Odometry, MujocoEngine]:
    """Drive from rest; returns the true pose, the odometry and the engine."""
    engine = MujocoEngine()
    engine.build(load_world("empty").scene)
    odometry = Odometry(DECLARATION.drive, DECLARATION.odometry, Noise(seed, "odometry"))
    engine.command_wheels(ROBOT, *wheel_speeds(DECLARATION.drive, velocity))
    for step in range(1, round(seconds * engine.steps_per_second) + 1):
        engine.step()
        if step % TICK_STEPS == 0:
            odometry.update(engine.wheel_angles(ROBOT), 0.02, step // TICK_STEPS)
    return engine.body_state(ROBOT).planar, odometry, engine


def test_a_straight_drive_is_straight_and_as_long_as_commanded() -> None:
    pose, odometry, _ = drive(Velocity(0.3, 0.0), 10.0)
    assert pose.x == pytest.approx(3.0, rel=0.03)
    assert abs(pose.y) < 1e-3
    assert odometry.travelled == pytest.approx(pose.x, rel=0.03)
    assert odometry.velocity.linear == pytest.approx(0.3, rel=0.1)


def test_turning_in_place_stays_in_place() -> None:
    pose, odometry, _ = drive(Velocity(0.0, 1.0), 3.0)
    assert pose.yaw == pytest.approx(3.0, rel=0.06)
    assert math.hypot(pose.x, pose.y) < 0.02
    assert odometry.pose.yaw == pytest.approx(pose.yaw, abs=0.15)


def test_odometry_errors_grow_with_the_way_and_depend_on_the_seed() -> None:
    truth, first, _ = drive(Velocity(0.3, 0.2), 10.0, seed=1)
    _, second, _ = drive(Velocity(0.3, 0.2), 10.0, seed=2)
    errors = [odometry.pose.distance(truth.x, truth.y) for odometry in (first, second)]
    assert all(0.002 < error < 0.5 for error in errors)
    assert errors[0] != errors[1]


def test_odometry_at_rest_has_no_errors() -> None:
    _, odometry, _ = drive(Velocity(0.0, 0.0), 2.0)
    assert odometry.travelled < 1e-3
    assert odometry.pose == pytest.approx((0.0, 0.0, 0.0), abs=1e-3)


def test_the_robot_stands_level_and_stops_in_a_short_way() -> None:
    _, _, engine = drive(Velocity(0.3, 0.0), 2.0)
    before = engine.body_state(ROBOT)
    engine.command_wheels(ROBOT, 0.0, 0.0)
    for _ in range(100):
        engine.step()
    after = engine.body_state(ROBOT)
    assert abs(after.position[2]) < 2e-3
    assert after.position[0] - before.position[0] < 0.05
    assert abs(after.linear[0]) < 1e-3
