"""Declarations of three lines: name, model and drive."""

from __future__ import annotations

from importlib import util
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest

from seoro.bridges import wire
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.__main__ import ENGINES
from sim_nodes.check.bench import BASE, LIDAR, TURTLEBOT
from sim_nodes.robots import reading
from sim_nodes.robots.declaration import MobileDeclaration, RobotDeclaration
from sim_nodes.robots.drive_declaration import DifferentialDrive, DriveKind, PlanarDrive
from sim_nodes.robots.reading import read_robot
from sim_nodes.worlds.loader import WorldError, load_world
from tests.sim_nodes import robots_of_makers as makers
from tests.sim_nodes.client import Client, pose


def declaration_of(path: str) -> tuple[RobotDeclaration, MobileDeclaration]:
    declaration = load_world(path).robots[0].declaration
    assert declaration.mobile is not None
    return declaration, declaration.mobile


def test_the_values_of_a_robot_are_those_of_its_long_declaration(tmp_path: Path) -> None:
    urdf = Path(str(reading.__file__)).parent / "turtlebot4.urdf"
    path = tmp_path / "short.yaml"
    path.write_text(f"model: turtlebot4\nurdf: {urdf}\ndrive: differential\n")
    short = read_robot(path)
    assert short.mobile is not None and short.mobile.lidar is not None
    drive, wanted = short.mobile.drive, BASE.drive
    assert isinstance(drive, DifferentialDrive) and isinstance(wanted, DifferentialDrive)
    for key in ("left_joint", "right_joint", "wheel_radius", "wheel_separation"):
        assert getattr(drive, key) == getattr(wanted, key)
    lidar = short.mobile.lidar
    assert (lidar.link, lidar.x) == (LIDAR.link, LIDAR.x)
    assert lidar.yaw == pytest.approx(LIDAR.yaw, abs=1e-6)
    assert (short.kinds, short.base_link) == (TURTLEBOT.kinds, TURTLEBOT.base_link)
    assert short.low_friction_links == TURTLEBOT.low_friction_links
    assert (short.urdf, short.source) == (TURTLEBOT.urdf, short.source)
    assert short.mobile.radius == pytest.approx(BASE.radius, abs=0.006)
    footprint = short.mobile.footprint
    assert footprint is not None
    assert footprint.inner_radius >= BASE.radius - 1e-3


@pytest.mark.parametrize("engine", ENGINES)
def test_a_robot_with_the_frames_of_its_maker_drives(engine: str, tmp_path: Path) -> None:
    path = makers.write_robot(tmp_path, makers.two_wheels(), "differential")
    client = Client(path, engine=engine)
    client.ask(wire.DRIVE, wire.Drive(id="d", robot="mine", linear=0.3, angular=0.0, duration=3.0))
    client.run_until("d")
    there = client.simulator.simulation.frames.true_pose("mine")
    assert (there.x, there.y, there.yaw) == pytest.approx((1.84, 0.0, 0.0), abs=0.03)
    client.ask(wire.DRIVE, wire.Drive(id="t", robot="mine", linear=0.0, angular=0.8, duration=2.0))
    client.run_until("t")
    turned = client.simulator.simulation.frames.true_pose("mine")
    assert turned.yaw == pytest.approx(1.5, abs=0.12)
    # The base is between the wheels, not in the middle of the body.
    assert turned.distance(there.x, there.y) < 0.05


def test_the_model_is_adapted_to_its_drive(tmp_path: Path) -> None:
    declaration, mobile = declaration_of(makers.write_robot(tmp_path, makers.two_wheels(), "differential"))
    drive = mobile.drive
    assert isinstance(drive, DifferentialDrive)
    assert (drive.wheel_radius, drive.wheel_separation) == pytest.approx((makers.RADIUS, 2 * makers.HALF_TRACK))
    assert drive.max_speed == pytest.approx(10 * makers.RADIUS)
    assert drive.motor_torque == 3.0
    assert declaration.base_link == "base_footprint"
    assert 'link name="base_footprint"' in declaration.source
    assert declaration.low_friction_links == ("caster",)
    words = ("new link 'base_footprint'", "turned the axes of left_joint, right_joint", "held at 0: swivel")
    notes = "\n".join(declaration.notes)
    assert all(word in notes for word in (*words, "roll as cylinders: left, right", "no lidar"))
    footprint = mobile.footprint
    assert footprint is not None
    assert tuple(footprint.points.max(axis=0)) == pytest.approx((0.25 - makers.AXLE, 0.22), abs=2e-3)
    assert mobile.radius == pytest.approx(footprint.radius, abs=1e-4)


def test_sensors_of_gazebo_are_mounted(tmp_path: Path) -> None:
    path = makers.write_robot(tmp_path, makers.two_wheels(extra=makers.LIDAR), "differential")
    _, mobile = declaration_of(path)
    lidar = mobile.lidar
    assert lidar is not None
    assert (lidar.link, lidar.rate, lidar.min_range, lidar.max_range) == ("top", 20.0, 0.2, 8.0)
    assert lidar.beams == 362  # of a whole turn
    assert (lidar.x, lidar.y) == pytest.approx((0.1 - makers.AXLE, 0.0))


def test_own_values_replace_derived_ones(tmp_path: Path) -> None:
    more = "body_friction: 0.5\nmobile:\n  clearance: 0.5\n  drive: {max_speed: 0.4}\n"
    declaration, mobile = declaration_of(makers.write_robot(tmp_path, makers.two_wheels(), "differential", more))
    assert (declaration.body_friction, mobile.clearance, mobile.drive.max_speed) == (0.5, 0.5, 0.4)
    assert isinstance(mobile.drive, DifferentialDrive)
    assert mobile.drive.wheel_radius == pytest.approx(makers.RADIUS)


@pytest.mark.parametrize(
    ("urdf", "drive", "more", "words"),
    [
        (makers.two_wheels(), "hover", "", "unknown `drive` 'hover'; expected ackermann, arm, differential"),
        (makers.two_wheels(), "ackermann", "", "found 2 driven wheels for the drive `ackermann`; expected 3"),
        (makers.two_wheels(), "omnidirectional", "", "found: left_joint, right_joint"),
        (makers.two_wheels().replace("continuous", "fixed"), "differential", "", "found: none"),
        (
            makers.two_wheels().replace('effort="3"', 'effort="0.001"'),
            "differential",
            "",
            "effort limit of 0.001 N m",
        ),
        (
            makers.two_wheels(wheel='<sphere radius="0.08"/>'),
            "differential",
            "mobile: {drive: {wheel_radius: 0.8}}\n",
            "radius of 0.0800 m; `wheel_radius` declares 0.8000 m",
        ),
        (
            makers.two_wheels(),
            "differential",
            "mobile: {drive: {wheel_separation: 0.5}}\n",
            r"expected \(0, 0.2500\) by the declaration's `wheel_separation`",
        ),
        (makers.two_wheels(), "differential", "mobile: {drive: {motor_torque: .inf}}\n", "finite number"),
    ],
)
def test_contradictions_are_refused(urdf: str, drive: str, more: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(WorldError, match=words):
        load_world(makers.write_robot(tmp_path, urdf, drive, more))


def test_a_robot_without_lidar_is_localised_by_its_odometry(tmp_path: Path) -> None:
    client = Client(makers.write_robot(tmp_path, makers.two_wheels(), "differential"))
    robot = client.simulator.simulation.robot("mine")
    with pytest.raises(RequestRefused, match="mine has no lidar to find its pose by"):
        client.ask(wire.REINITIALIZE_GLOBAL_LOCALIZATION, wire.RobotName(robot="mine"))
    client.ask(wire.SET_INITIAL_POSE, wire.SetInitialPose(robot="mine", pose=pose(1.0, 0.0)))
    client.ask(wire.DRIVE, wire.Drive(id="d", robot="mine", linear=0.3, angular=0.3, duration=4.0))
    client.run_until("d")
    believed, odometry = robot.mobile.localised_pose(), robot.mobile.odometry.pose
    offset = robot.mobile.localisation.map_to_odom()
    assert believed is not None and offset is not None
    assert believed == pytest.approx(offset.compose(odometry))
    truth = client.simulator.simulation.frames.true_pose("mine")
    assert 0.0 < believed.distance(truth.x, truth.y) < 0.2
    [description] = [client.ask(wire.GET_ROBOT_DESCRIPTION, wire.RobotName(robot="mine"))]
    assert description.lidar is None and "lidar" not in description.sensors


FOREIGN = (("husky", "differential", DriveKind.SKID_STEER), ("racecar", "ackermann", DriveKind.ACKERMANN))


@pytest.mark.skipif(util.find_spec("pybullet_data") is None, reason="pybullet_data is not installed")
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(("name", "drive", "kind"), FOREIGN)
def test_robots_of_makers_drive(name: str, drive: str, kind: DriveKind, engine: str, tmp_path: Path) -> None:
    urdf = Path(str(files("pybullet_data"))) / name / f"{name}.urdf"
    (tmp_path / "robot.yaml").write_text(f"model: {name}\nurdf: {urdf}\ndrive: {drive}\n")
    (tmp_path / "w.yaml").write_text(makers.WORLD)
    client = Client(str(tmp_path / "w.yaml"), engine=engine)
    _, mobile = declaration_of(str(tmp_path / "w.yaml"))
    assert isinstance(mobile.drive, PlanarDrive) and mobile.drive.kind is kind
    client.ask(wire.DRIVE, wire.Drive(id="d", robot="mine", linear=0.4, angular=0.3, duration=3.0))
    client.run_until("d")
    there = client.simulator.simulation.frames.true_pose("mine")
    assert there.yaw == pytest.approx(0.3 * 3.0 * 0.95, rel=0.1)
    assert np.hypot(there.x - 1.0, there.y) == pytest.approx(1.07, abs=0.1)
