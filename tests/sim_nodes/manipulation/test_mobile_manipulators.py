"""Mobile bases with an arm: of their own model, or mounted on them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from seoro.bridges import wire
from seoro.bridges.wire import Outcome
from sim_nodes.manipulation.chain import Chain
from sim_nodes.robots.declaration import ArmDeclaration
from sim_nodes.robots.reading import read_robot
from sim_nodes.worlds.loader import WorldError, load_world
from tests.sim_nodes import robots_of_makers as makers
from tests.sim_nodes.client import Client
from tests.sim_nodes.manipulation.test_bodies_of_joints import ENGINES
from tests.sim_nodes.test_snapshots import restore, save

LINK = 0.15  # [m] of the arm
MOUNTED = "mounted: {robot: ur10e, link: chassis, x: -0.05, z: 0.05}\n"
FOLDED = "home: {arm_shoulder_lift_joint: -2.2, arm_elbow_joint: 2.5, arm_wrist_1_joint: -1.87}\n"


def lift_and_arm() -> str:
    """Return the links and joints of an arm: a lift, and two links that stretch ahead."""
    text, parent = "", "chassis"
    for name, kind, axis, place in (
        ("lift", "prismatic", "0 0 1", "0 0 0.05"),
        ("upper", "revolute", "0 1 0", "0 0 0.1"),
        ("lower", "revolute", "0 1 0", f"{LINK} 0 0"),
    ):
        text += (
            f'<link name="{name}"><inertial><origin xyz="{LINK / 2} 0 0"/><mass value="0.5"/>'
            f'{makers.INERTIA.format(0.002)}</inertial><collision><origin xyz="{LINK / 2} 0 0"/><geometry>'
            f'<box size="{LINK - 0.02} 0.03 0.03"/></geometry></collision></link>'
            f'<joint name="{name}_joint" type="{kind}"><origin xyz="{place}"/><parent link="{parent}"/>'
            f'<child link="{name}"/><axis xyz="{axis}"/><limit lower="-1.5" upper="1.5" effort="30" velocity="1"/>'
            "</joint>"
        )
        parent = name
    return text


def own_arm(folder: Path, more: str = "arm: {}\n") -> str:
    """Write a world with a base that has a lift and an arm; return its path."""
    return makers.write_robot(folder, makers.two_wheels(extra=lift_and_arm()), "differential", more)


def arm_of(path: str) -> ArmDeclaration:
    """Return the arm of the robot of a world."""
    arm = load_world(path).robots[0].declaration.arm
    assert arm is not None
    return arm


def follow(client: Client, *positions: float) -> wire.Occurrence:
    """Move the joints of `mine`; return the result."""
    request = wire.FollowJointTrajectory(id="move", robot="mine", points=(positions,), tolerance=0.01)
    client.ask(wire.FOLLOW_JOINT_TRAJECTORY, request)
    return client.run_until("move")[0]


def positions_of(client: Client) -> tuple[float, ...]:
    return client.ask(wire.GET_JOINT_STATES, wire.RobotName(robot="mine")).positions


@pytest.mark.parametrize("engine", ENGINES)
def test_a_base_drives_with_the_arm_that_it_carries(tmp_path: Path, engine: str) -> None:
    client = Client(own_arm(tmp_path), engine=engine)
    state = client.simulator.simulation.engine.body_state
    client.advance(0.5)
    # Motors hold the arm without sagging, and its weight is on the wheels.
    assert positions_of(client) == pytest.approx((0.0, 0.0, 0.0), abs=1e-3)
    assert follow(client, 0.1, -0.5, 0.8).outcome is Outcome.SUCCEEDED
    client.ask(wire.DRIVE, wire.Drive(id="d", robot="mine", linear=0.3, angular=0.0, duration=2.0))
    assert client.run_until("d")[0].outcome is Outcome.SUCCEEDED
    assert state("mine").position[0] == pytest.approx(1.0 + 0.56, abs=0.06)
    assert state("mine").position[2] == pytest.approx(0.0, abs=2e-3)
    assert positions_of(client) == pytest.approx((0.1, -0.5, 0.8), abs=5e-3)
    there = client.ask(wire.GET_ARM_STATE, wire.RobotName(robot="mine")).tool.position
    assert there.x - state("mine").position[0] > 0.1


def test_the_outline_is_that_with_the_arm_at_home(tmp_path: Path) -> None:
    radii = []
    for home in (0.0, -1.5):
        path = own_arm(tmp_path, f"arm: {{}}\nhome: {{upper_joint: {home}}}\n")
        declaration = load_world(path).robots[0].declaration
        assert declaration.mobile is not None
        assert declaration.kinds[0] == "mobile_manipulator"
        assert declaration.base_link == "base_footprint"
        radii.append(declaration.mobile.radius)
    assert radii[0] > radii[1] + 0.005


def test_names_of_a_mounted_robot_have_its_prefix(tmp_path: Path) -> None:
    path = makers.write_robot(tmp_path, makers.two_wheels(), "differential", MOUNTED + FOLDED)
    robot = read_robot(tmp_path / "robot.yaml")
    arm = arm_of(path)
    assert arm.joints[0].name == "arm_shoulder_pan_joint"
    assert (arm.tool_link, arm.joints[1].home) == ("arm_tcp", -2.2)
    assert arm.gripper is not None
    assert arm.gripper.links == ("arm_left_finger", "arm_right_finger")
    assert [camera.link for camera in robot.cameras] == ["arm_gripper_palm"]
    chain = Chain(robot.urdf, "base_footprint", "arm_base_link", [])
    assert chain.tool_pose(np.zeros(0))[:3, 3] == pytest.approx((-0.05 - makers.AXLE, 0.0, 0.05 + makers.HEIGHT))


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ("mounted: {robot: ur10e, link: roof}\n", "unknown `mounted.link` 'roof'; the base has"),
        ("mounted: {robot: crane}\n", "unknown `mounted.robot` 'crane'"),
        ("mounted: {robot: turtlebot4}\n", "expected a robot with an arm, without a drive"),
        ("mounted: {height: 1.0}\n", "invalid `mounted.robot`: Field required"),
        (MOUNTED + "home: {elbow_joint: 1.0}\n", "`home` names the unknown joint 'elbow_joint'"),
        ("arm: {tool_link: left}\n", "the arm moves 'left_joint', a wheel"),
    ],
)
def test_arms_that_do_not_fit_are_refused(tmp_path: Path, more: str, words: str) -> None:
    with pytest.raises(WorldError) as refused:
        load_world(makers.write_robot(tmp_path, makers.two_wheels(), "differential", more))
    assert words in str(refused.value)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_moving_mobile_manipulator_continues_from_a_snapshot(tmp_path: Path, engine: str) -> None:
    ends = []
    original = Client(own_arm(tmp_path), engine=engine)
    original.ask(wire.DRIVE, wire.Drive(id="d", robot="mine", linear=0.3, angular=0.3, duration=1.5))
    request = wire.FollowJointTrajectory(id="move", robot="mine", points=((0.1, -0.5, 0.8),))
    original.ask(wire.FOLLOW_JOINT_TRAJECTORY, request)
    original.advance(0.5)
    snapshot = save(original)
    for client in (original, Client("empty", 99, engine)):
        if client is not original:
            restore(client, snapshot)
        client.advance(2.0)
        state = client.simulator.simulation.engine.body_state("mine")
        ends.append((state, client.ask(wire.GET_JOINT_STATES, wire.RobotName(robot="mine"))))
    assert ends[0] == ends[1]


@pytest.mark.parametrize("engine", ENGINES)
def test_rays_of_a_robot_pass_through_all_its_links(tmp_path: Path, engine: str) -> None:
    client = Client(own_arm(tmp_path), engine=engine)
    angles = np.linspace(0.0, 2.0 * np.pi, 36, endpoint=False)
    directions = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(36)])
    cast = client.simulator.simulation.engine.cast_rays
    assert np.isinf(cast("mine", "lift", directions, 3.0)).all()
