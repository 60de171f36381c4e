"""Arms with joints that slide: their limits are in metres, and inverse kinematics moves them."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from seoro.bridges import wire
from seoro.bridges.wire import Outcome
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.manipulation import inverse_kinematics
from sim_nodes.manipulation.chain import Chain
from sim_nodes.manipulation.inverse_kinematics import pose_error, solutions
from sim_nodes.noise import Noise
from sim_nodes.robots.declaration import ArmDeclaration
from sim_nodes.robots.reading import read_robot
from tests.sim_nodes.client import Client
from tests.sim_nodes.manipulation.cell import down
from tests.sim_nodes.manipulation.test_bodies_of_joints import ENGINES

AXES = ("1 0 0", "0 1 0", "0 0 -1", "0 0 1", "0 1 0", "0 0 1")
HOME = {"j1": 0.2, "j3": 0.1, "j5": 1.57}


def gantry() -> str:
    """Return the URDF of three joints that slide, above a wrist of three that turn."""
    inertial = (
        '<inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>'
    )
    text = '<robot name="gantry"><link name="base"/>'
    for number, axis in enumerate(AXES, 1):
        kind, low, high = ("prismatic", -0.5, 0.5) if number <= 3 else ("revolute", -3.3, 3.3)
        place = "0 0 1" if number == 1 else "0 0 -0.1" if number > 3 else "0 0 0"
        text += (
            f'<link name="l{number}">{inertial}<collision><geometry><sphere radius="0.02"/></geometry></collision>'
            f'</link><joint name="j{number}" type="{kind}"><origin xyz="{place}"/>'
            f'<parent link="{f"l{number - 1}" if number > 1 else "base"}"/><child link="l{number}"/>'
            f'<axis xyz="{axis}"/><limit lower="{low}" upper="{high}" velocity="1" effort="100"/></joint>'
        )
    return f"{text}</robot>"


def write_gantry(folder: Path) -> str:
    """Write a world with a gantry, `mine`; return its path."""
    (folder / "mine.urdf").write_text(gantry())
    (folder / "mine.yaml").write_text(f"model: gantry\nurdf: mine.urdf\ndrive: arm\nhome: {HOME}\n")
    path = folder / "w.yaml"
    path.write_text("name: w\nextent: [-2, -2, 2, 2]\nrobots: [{name: mine, robot: mine.yaml}]\n")
    return str(path)


def declared_arm(folder: Path) -> tuple[ArmDeclaration, Chain]:
    """Return the arm of a gantry, and its chain."""
    write_gantry(folder)
    robot = read_robot(folder / "mine.yaml")
    arm = robot.arm
    assert arm is not None and arm.tool_link is not None
    return arm, Chain(robot.urdf, robot.base_link, arm.tool_link, [joint.name for joint in arm.joints])


@pytest.mark.parametrize("engine", ENGINES)
def test_a_gantry_moves_to_poses(tmp_path: Path, engine: str) -> None:
    client = Client(write_gantry(tmp_path), engine=engine)
    goal = down(0.4, -0.3, 0.55)
    request = wire.MoveToPose(id="move", robot="mine", pose=goal, frame="base_link")
    client.ask(wire.MOVE_TO_POSE, request)
    ended = client.run_until("move")[0]
    assert ended.outcome is Outcome.SUCCEEDED, ended.message
    there = client.ask(wire.GET_ARM_STATE, wire.RobotName(robot="mine")).tool.position
    assert (there.x, there.y, there.z) == pytest.approx((0.4, -0.3, 0.55), abs=3e-3)


def test_limits_of_sliding_joints_are_in_metres(tmp_path: Path) -> None:
    client = Client(write_gantry(tmp_path))
    request = wire.FollowJointTrajectory(id="move", robot="mine", points=((0.6, 0.0, 0.0, 0.0, 0.0, 0.0),))
    with pytest.raises(
        RequestRefused, match=r"invalid position 0\.600 m of j1 of mine; expected -0\.500 to 0\.500 m"
    ):
        client.ask(wire.FOLLOW_JOINT_TRAJECTORY, request)


def test_the_motor_of_a_sliding_joint_is_derived(tmp_path: Path) -> None:
    lift = declared_arm(tmp_path)[0].joints[2]
    assert lift.stiffness == 100.0 / 0.02
    # Four links of 1 kg hang on it; critical damping.
    assert lift.damping == pytest.approx(2.0 * math.sqrt(5000.0 * (4.0 + lift.armature)), rel=1e-6)


def test_reachable_poses_of_a_gantry_are_found(tmp_path: Path) -> None:
    _, chain = declared_arm(tmp_path)
    draw = np.random.default_rng(0)
    for _ in range(8):
        target = chain.tool_pose(draw.uniform(chain.limits.lower, chain.limits.upper))
        start = draw.uniform(chain.limits.lower, chain.limits.upper)
        found = next(solutions(chain, target, start, np.zeros(6), Noise(0, "test")))
        assert max(pose_error(chain.tool_pose(found), target)) < 1e-5
        assert np.all((found >= chain.limits.lower) & (found <= chain.limits.upper))


def test_poses_beyond_reach_are_not_searched(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    _, chain = declared_arm(tmp_path)
    monkeypatch.setattr(inverse_kinematics, "solve", lambda *_: pytest.fail("searched"))
    target = np.eye(4)
    target[0, 3] = chain.reach + 0.1
    assert list(solutions(chain, target, np.zeros(6), np.zeros(6), Noise(0, "test"))) == []
