"""Robots by reference, and short declarations of arms and jointed bodies."""

from __future__ import annotations

from fnmatch import fnmatchcase
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path

import pytest

from seoro.bridges import wire
from seoro.bridges.wire import Outcome
from seoro.files.yaml_lines import FileError
from sim_nodes.manipulation.chain import joint_limits
from sim_nodes.robots.declaration import RobotDeclaration
from sim_nodes.robots.reading import load_robot, read_robot
from sim_nodes.robots.references import catalogue
from sim_nodes.robots.references.catalogue import available_references
from sim_nodes.worlds.loader import WorldError, load_world
from tests.sim_nodes.client import Client
from tests.sim_nodes.manipulation.test_bodies_of_joints import ENGINES, four_legs

LENGTH = 0.3  # [m] of a link of the test arm


def world(folder: Path, robot: str) -> str:
    """Write a world with a robot, `mine`; return its path."""
    path = folder / "w.yaml"
    path.write_text(f"name: w\nextent: [-4, -4, 4, 4]\nrobots: [{{name: mine, robot: {robot}}}]\n")
    return str(path)


def three_joints(*, velocity: str = "2", type_of_last: str = "continuous") -> str:
    """Return the URDF of an arm of three joints with a tool frame without inertia."""
    text = '<robot name="three"><link name="base"/>'
    kinds = (("revolute", "0 0 1"), ("revolute", "0 1 0"), (type_of_last, "0 1 0"))
    for number, (kind, axis) in enumerate(kinds, 1):
        parent = "base" if number == 1 else f"l{number - 1}"
        text += (
            f'<link name="l{number}"><inertial><origin xyz="0 0 0.15"/><mass value="1"/><inertia ixx="0.01" '
            'iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial><collision><origin xyz="0 0 0.15"/>'
            f'<geometry><box size="0.05 0.05 0.2"/></geometry></collision></link><joint name="j{number}" '
            f'type="{kind}"><origin xyz="0 0 {LENGTH}"/><parent link="{parent}"/><child link="l{number}"/>'
            f'<axis xyz="{axis}"/><limit lower="-1" upper="2" velocity="{velocity}" effort="20"/></joint>'
        )
    text += '<link name="tool"/><joint name="tip" type="fixed"><origin xyz="0 0 0.3"/>'
    return text + '<parent link="l3"/><child link="tool"/></joint></robot>'


def declare(folder: Path, urdf: str, further: str) -> Path:
    """Write a short declaration; return its path."""
    (folder / "mine.urdf").write_text(urdf)
    path = folder / "mine.yaml"
    path.write_text(f"model: mine\nurdf: mine.urdf\n{further}\n")
    return path


def test_three_lines_declare_an_arm(tmp_path: Path) -> None:
    robot = read_robot(declare(tmp_path, three_joints(), "drive: arm"))
    assert robot.fixed
    arm = robot.arm
    assert arm is not None
    assert (arm.tool_link, arm.gripper) == ("tool", None)
    assert [(joint.name, joint.home) for joint in arm.joints] == [("j1", 0.0), ("j2", 0.0), ("j3", 0.0)]
    assert arm.joints[0].stiffness == 20.0 / 0.05
    limits = joint_limits(robot.urdf, ["j1", "j3"])
    assert limits.lower.tolist() == [-1.0, pytest.approx(-6.283185307179586)]


def test_home_and_tool_may_be_given(tmp_path: Path) -> None:
    path = declare(tmp_path, three_joints(), "drive: arm\nhome: {'j[12]': 0.5}\narm: {tool_link: l2}")
    arm = read_robot(path).arm
    assert arm is not None
    assert [(joint.name, joint.home) for joint in arm.joints] == [("j1", 0.5), ("j2", 0.5)]


def test_a_missing_velocity_limit_is_noted(tmp_path: Path) -> None:
    robot = read_robot(declare(tmp_path, three_joints(velocity="0"), "drive: arm"))
    assert "without a velocity limit, so 2 rad/s: j1, j2, j3" in robot.notes
    assert joint_limits(robot.urdf, ["j1"]).speed.tolist() == [2.0]


@pytest.mark.parametrize(
    ("further", "words"),
    [
        ("drive: arm\nhome: {elbow: 1.0}", "`home` names the unknown joint 'elbow'"),
        ("drive: arm\nhome: [1.0]", "invalid `home`"),
        ("drive: arm\nhome: {j1: 3.0}", "invalid `home` 3.000 rad of j1; expected -1.000 to 2.000 rad"),
        ("drive: arm\narm: {tool_link: hand}", "unknown `tool_link` 'hand'"),
        ("drive: legs", "unknown `drive` 'legs'; expected"),
    ],
)
def test_short_declarations_that_do_not_fit_are_refused(tmp_path: Path, further: str, words: str) -> None:
    with pytest.raises(FileError) as refused:
        read_robot(declare(tmp_path, three_joints(), further))
    assert words in str(refused.value)


def test_a_joint_of_an_arm_may_slide(tmp_path: Path) -> None:
    arm = read_robot(declare(tmp_path, three_joints(type_of_last="prismatic"), "drive: arm")).arm
    assert arm is not None
    assert arm.joints[2].stiffness == 20.0 / 0.02


def test_an_endless_sliding_joint_is_refused(tmp_path: Path) -> None:
    urdf = three_joints(type_of_last="prismatic").replace('lower="-1" upper="2"', "")
    with pytest.raises(FileError, match="missing limits of the joint 'j3', which slides"):
        read_robot(declare(tmp_path, urdf, "drive: arm"))


def test_three_lines_declare_a_body_on_legs(tmp_path: Path) -> None:
    robot = read_robot(declare(tmp_path, four_legs(), "drive: joints"))
    assert robot.arm is not None
    assert (len(robot.arm.joints), robot.arm.tool_link, robot.fixed) == (4, None, False)
    assert robot.standing_height == pytest.approx(0.3)


def test_a_missing_package_of_a_reference_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> Distribution:
        raise PackageNotFoundError(name)

    monkeypatch.setattr(catalogue, "distribution", missing)
    load_robot.cache_clear()
    with pytest.raises(WorldError, match=r"robots\.0\.robot: .* not installed; run `pip install pybullet`"):
        load_world(world(tmp_path, "mini_cheetah"))


def test_references_name_their_licence() -> None:
    for name in available_references():
        source = catalogue.find_reference(name).source
        assert source.package
        assert source.licence


SOME = ("a1", "franka_panda", "husky", "jvrc1")
# Joints of humanoids that may move without a step.
OF_ARMS = {"jvrc1": "*_SHOULDER_R", "g1": "*_shoulder_roll_joint", "talos": "arm_*_2_joint", "romeo": "*ElbowRoll"}


def load_installed(name: str) -> RobotDeclaration:
    """Load a robot by reference; skip the test if its package is not installed."""
    source = catalogue.find_reference(name).source
    try:
        distribution(source.package)
    except PackageNotFoundError:
        pytest.skip(f"the package {source.package} is not installed")
    return load_robot(name)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    "name",
    [each if each in SOME else pytest.param(each, marks=pytest.mark.slow) for each in available_references()],
)
def test_robots_by_reference_move(tmp_path: Path, name: str, engine: str) -> None:
    robot = load_installed(name)
    client = Client(world(tmp_path, name), engine=engine)
    state = client.simulator.simulation.engine.body_state
    if robot.arm is None:
        client.ask(wire.DRIVE, wire.Drive(id="move", robot="mine", linear=0.3, angular=0.0, duration=2.0))
        assert client.run_until("move")[0].outcome is Outcome.SUCCEEDED
        assert 0.4 < state("mine").position[0] < 0.65
        return
    client.advance(1.0)
    height = state("mine").position[2]
    assert height == pytest.approx(robot.standing_height, abs=0.01)
    upper = joint_limits(robot.urdf, [joint.name for joint in robot.arm.joints]).upper
    points = [
        joint.home + (0.1 if joint.home + 0.1 < most else -0.1) * fnmatchcase(joint.name, OF_ARMS.get(name, "*"))
        for joint, most in zip(robot.arm.joints, upper, strict=True)
    ]
    request = wire.FollowJointTrajectory(
        id="move", robot="mine", points=(points,), max_velocity_scaling_factor=0.1, tolerance=0.02
    )
    client.ask(wire.FOLLOW_JOINT_TRAJECTORY, request)
    ended = client.run_until("move")[0]
    assert ended.outcome is Outcome.SUCCEEDED, ended.message
    assert abs(state("mine").position[2] - height) < 0.05
    assert state("mine").orientation[0] > 0.95


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
def test_a_hand_with_much_damping_opens(tmp_path: Path, engine: str) -> None:
    robot = load_installed("allegro_hand")
    assert robot.arm is not None
    client = Client(world(tmp_path, "allegro_hand"), engine=engine)
    joints = tuple(robot.arm.home)
    for posture in reversed(robot.postures):  # closed, then open
        positions = robot.arm.home | posture.of(joints)
        request = wire.FollowJointTrajectory(
            id=posture.name,
            robot="mine",
            points=(tuple(positions[joint] for joint in joints),),
            max_velocity_scaling_factor=0.05,
            tolerance=0.05,
        )
        client.ask(wire.FOLLOW_JOINT_TRAJECTORY, request)
        ended = client.run_until(posture.name)[0]
        assert ended.outcome is Outcome.SUCCEEDED, ended.message
