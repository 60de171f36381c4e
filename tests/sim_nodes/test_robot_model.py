from __future__ import annotations

import math

import pytest

from sim_nodes.check.bench import BASE, LIDAR
from sim_nodes.geometry import yaw_of
from sim_nodes.robots.drive_declaration import DifferentialDrive
from sim_nodes.robots.kinematics import Velocity, base_motion, motor_commands
from sim_nodes.robots.reading import available_robots, load_robot

pytest.importorskip("mujoco", reason="the engine mujoco is not installed")

import mujoco

from sim_nodes.mujoco.groups import SEEN_BY_RAYS
from sim_nodes.mujoco.model import robot_spec


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    return robot_spec(load_robot("turtlebot4")).compile()


def test_the_robots_are_available() -> None:
    assert available_robots()[:2] == ("turtlebot4", "ur10e")
    assert load_robot("turtlebot4").kinds == ("differential_drive_robot", "robot", "osc_actor")


def test_engines_load_all_links_and_masses(model: mujoco.MjModel) -> None:
    links = {model.body(index).name for index in range(1, model.nbody)}
    assert links == {"base_link", "left_wheel", "right_wheel", "front_caster", "rplidar_link"}
    assert model.body_mass.sum() == pytest.approx(2.69 + 2 * 0.2 + 0.01 + 0.17)


def test_declarations_match_their_urdf(model: mujoco.MjModel) -> None:
    declaration = BASE
    drive, lidar = declaration.drive, LIDAR
    assert isinstance(drive, DifferentialDrive)
    left, right = (model.body(f"{side}_wheel") for side in ("left", "right"))
    assert left.pos[1] - right.pos[1] == pytest.approx(drive.wheel_separation)
    assert left.pos[2] == pytest.approx(drive.wheel_radius)
    mount = model.body(lidar.link)
    assert tuple(mount.pos[:2]) == pytest.approx((lidar.x, lidar.y))
    assert yaw_of(tuple(mount.quat)) == pytest.approx(lidar.yaw)
    solid = [index for index in range(model.ngeom) if model.geom_contype[index]]
    assert max(model.geom_size[index][0] for index in solid) == declaration.radius
    assert {model.geom_group[index] for index in solid} <= set(SEEN_BY_RAYS)


def test_wheel_speeds_and_base_motion_are_inverse() -> None:
    drive = BASE.drive
    assert base_motion(drive, motor_commands(drive, Velocity(0.2, -0.7))) == pytest.approx((0.2, -0.7, 0.0))
    assert motor_commands(drive, Velocity(0.0, math.pi))[0] < 0.0
