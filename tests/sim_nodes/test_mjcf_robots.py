"""Robots of three lines whose models are MJCF files."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from seoro.bridges import wire
from seoro.bridges.wire import Outcome
from seoro.robotics.geometry import Pose3D, Position3D
from sim_nodes.manipulation.chain import joint_limits
from sim_nodes.robots.declaration import ArmDeclaration, RobotDeclaration
from sim_nodes.robots.reading import read_robot
from tests.sim_nodes.client import Client
from tests.sim_nodes.manipulation.cell import box
from tests.sim_nodes.manipulation.test_bodies_of_joints import ENGINES
from tests.sim_nodes.mjcf_robots import four_legs, linkage_gripper, sliding_gripper, two_wheels, write_robot
from tests.sim_nodes.test_snapshots import restore, save

pytest.importorskip("mujoco")
WIDTH = 0.04  # [m] of the box


def read(folder: Path, mjcf: str, drive: str, more: str = "") -> RobotDeclaration:
    write_robot(folder, mjcf, drive, more)
    return read_robot(folder / "robot.yaml")


def arm_of(robot: RobotDeclaration) -> ArmDeclaration:
    assert robot.arm is not None
    return robot.arm


def grip(client: Client, opening: float) -> wire.Occurrence:
    client.ask(wire.GRIPPER_COMMAND, wire.GripperCommand(id="g", robot="mine", opening=opening, tolerance=2e-3))
    return client.run_until("g")[0]


def state_of(client: Client) -> wire.ArmState:
    return client.ask(wire.GET_ARM_STATE, wire.RobotName(robot="mine"))


def test_joints_limits_and_home_are_those_of_the_file(tmp_path: Path) -> None:
    robot = read(tmp_path, sliding_gripper(), "arm")
    arm = arm_of(robot)
    assert [joint.name for joint in arm.joints] == ["turn", "shoulder", "elbow", "wrist"]
    # The file counts the shoulder from 10 degrees.
    assert arm.home == pytest.approx({"turn": 0.0, "shoulder": 0.7 - math.radians(10), "elbow": 0.9, "wrist": 0.0})
    limits = joint_limits(robot.urdf, ["shoulder"])
    assert np.degrees([*limits.lower, *limits.upper]) == pytest.approx([-170.0, 150.0])
    assert arm.joints[0].stiffness == pytest.approx(60.0 / 0.05)
    assert [posture.name for posture in robot.postures] == ["home", "up"]
    assert arm.gripper is not None
    assert [arm.gripper.stroke, arm.gripper.max_force] == pytest.approx([0.08, 40.0])


def test_a_home_of_the_declaration_replaces_the_keyframe(tmp_path: Path) -> None:
    arm = arm_of(read(tmp_path, sliding_gripper(), "arm", "home: {elbow: 0.5}"))
    assert [arm.home["elbow"], arm.home["shoulder"]] == pytest.approx([0.5, 0.7 - math.radians(10)])


def test_a_linkage_follows_its_driven_joint(tmp_path: Path) -> None:
    robot = read(tmp_path, linkage_gripper(), "arm")
    gripper = arm_of(robot).gripper
    assert gripper is not None
    assert gripper.joints == ("left_driver", "right_driver")
    assert gripper.links == ("left_finger", "right_finger")
    assert gripper.turning is not None
    assert '<mimic joint="left_driver"' in robot.urdf


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("gripper", [sliding_gripper, linkage_gripper])
def test_grippers_of_mjcf_lift_a_box(tmp_path: Path, gripper: Callable[[], str], engine: str) -> None:
    world = write_robot(tmp_path, gripper(), "arm", "home: {shoulder: -0.5, elbow: 2.07, wrist: 0.0}")
    (tmp_path / "w.yaml").write_text(
        "name: w\nextent: [-2, -2, 2, 2]\n"
        "walls: [{name: table, center: [0.0, 0.263], size: [0.2, 0.2], height: 0.08}]\n"
        "robots: [{name: mine, robot: robot.yaml}]\n"
    )
    client = Client(world, engine=engine)
    client.spawn("box", Pose3D(Position3D(0.0, 0.263, 0.12)), box(WIDTH, WIDTH, 0.08))
    stroke = state_of(client).opening
    assert stroke > WIDTH + 5e-3
    assert grip(client, 0.0).outcome is Outcome.SUCCEEDED
    assert state_of(client).held == "box"
    assert state_of(client).opening == pytest.approx(WIDTH, abs=4e-3)
    request = wire.FollowJointTrajectory(
        id="move", robot="mine", points=((0.0, -0.7, 2.27, 0.0),), max_velocity_scaling_factor=0.1, tolerance=0.03
    )
    client.ask(wire.FOLLOW_JOINT_TRAJECTORY, request)
    ended = client.run_until("move")[0]
    assert ended.outcome is Outcome.SUCCEEDED, ended.message
    assert client.simulator.simulation.engine.body_state("box").position[2] > 0.14
    assert grip(client, stroke).outcome is Outcome.SUCCEEDED
    assert state_of(client).opening == pytest.approx(stroke, abs=3e-3)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_base_of_mjcf_drives(tmp_path: Path, engine: str) -> None:
    client = Client(write_robot(tmp_path, two_wheels(), "differential"), engine=engine)
    start = client.simulator.simulation.engine.body_state("mine").position
    client.ask(wire.DRIVE, wire.Drive(id="move", robot="mine", linear=0.3, angular=0.0, duration=2.0))
    assert client.run_until("move")[0].outcome is Outcome.SUCCEEDED
    moved = np.subtract(client.simulator.simulation.engine.body_state("mine").position, start)
    assert moved == pytest.approx([0.58, 0.0, 0.0], abs=0.03)


@pytest.mark.parametrize("engine", ENGINES)
def test_legs_of_mjcf_stand_at_their_keyframe(tmp_path: Path, engine: str) -> None:
    client = Client(write_robot(tmp_path, four_legs(), "joints"), engine=engine)
    physics = client.simulator.simulation.engine
    client.advance(1.0)
    assert physics.body_state("mine").position[2] == pytest.approx(0.4 * math.cos(0.6) + 0.02, abs=0.01)
    points = (tuple([0.7, -1.4] * 4),)
    request = wire.FollowJointTrajectory(
        id="move", robot="mine", points=points, max_velocity_scaling_factor=0.1, tolerance=0.03
    )
    client.ask(wire.FOLLOW_JOINT_TRAJECTORY, request)
    ended = client.run_until("move")[0]
    assert ended.outcome is Outcome.SUCCEEDED, ended.message
    assert physics.body_state("mine").position[2] == pytest.approx(0.4 * math.cos(0.7) + 0.02, abs=0.01)


def test_robots_of_mjcf_continue_from_snapshots(tmp_path: Path) -> None:
    client = Client(write_robot(tmp_path, linkage_gripper(), "arm"))
    client.advance(0.5)
    snapshot = save(client)
    ends = []
    for each in (client, Client("empty", 99)):
        if each is not client:
            restore(each, snapshot)
        grip(each, 0.02)
        ends.append(each.simulator.simulation.engine.joint_states("mine").positions.tolist())
    assert ends[0] == ends[1]
