"""`osc.moveit2` and `osc.manipulation`, on simulator nodes."""

from pathlib import Path

import pytest

from seoro.cli.main import main
from tests.integration.conftest import read_trace
from tests.sim_nodes.manipulation.test_bodies_of_joints import four_legs, write_world

pytestmark = pytest.mark.engine("mujoco")

SCENARIO = """
import osc.manipulation
import osc.gazebo
import osc.helpers

scenario main:
    timeout(60s)
    robot: arm with:
        keep(it.arm_group == 'arm')
        keep(it.gripper_group == 'gripper')
        keep(it.end_effector == 'tcp')
        keep(it.base_link == 'base_link')
        keep(it.arm_joints == ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
            "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"])
    cube: sim_object
    above: pose_3d = pose_3d(position_3d(x: 65cm, y: 10cm, z: 15cm), orientation_3d(roll: 180deg))
    do serial:
        robot.move_to_joint_pose([0.3, -1.4, 1.4, -1.5708, -1.5708, 0.0], move_group_type!arm,
            max_velocity_scaling_factor: 0.8)
        MORE
"""
MORE = """
        parallel:
            robot.move_to_pose(above, max_velocity_scaling_factor: 0.8)
            robot.wait_for_joint("wrist_3_joint", -80deg)
            robot.release(60mm)
        robot.move_to_joint_pose(
            [0.04], move_group: move_group_type!gripper, max_velocity_scaling_factor: 1.0)
        cube.spawn(pose_3d(position_3d(x: 65cm, y: 10cm, z: 72.5cm)), 'manipulation://cube.sdf')
        robot.move_tool(pose_3d(position_3d(x: 65cm, y: 10cm, z: 73cm), orientation_3d(roll: 180deg)),
            frame_id: 'map', max_velocity_scaling_factor: 0.8)
        robot.grip('cube', 40N)
        robot.move_tool(above, max_velocity_scaling_factor: 0.8)
        robot.hold(duration: 1s)
        parallel:
            robot.hold('cube', 100s)
            robot.release()
"""


LEGS = "model: four\nurdf: mine.urdf\ndrive: joints\npostures: {lean: {'front_*': -0.3}}\n"
TAKING = """
import osc.manipulation

scenario main:
    mine: jointed_robot
    do serial:
        mine.take_posture('lean')
        mine.wait_for_joint('front_left_hip', -0.3rad)
        mine.take_posture('sit')
"""


def test_a_scenario_takes_postures(tmp_path: Path, capsys: pytest.CaptureFixture[str], mujoco_node: str) -> None:
    world = write_world(tmp_path, four_legs(), LEGS)
    (tmp_path / "main.osc").write_text(TAKING)
    options = ["--connect", mujoco_node, "--world", world, "--rate", "max"]
    assert main(["exec", str(tmp_path / "main.osc"), *options]) == 1
    shown = capsys.readouterr()
    assert "+ mine.wait_for_joint  succeeded" in shown.out + shown.err
    assert "unknown posture 'sit' of mine; postures: lean" in shown.err


def run(folder: Path, more: str, node: str) -> int:
    file = folder / "arm.osc"
    file.write_text(SCENARIO.replace("MORE", more.strip()))
    options = ["--connect", node, "--world", "arm_cell", "--rate", "max", "-o", str(folder)]
    return main(["exec", str(file), *options])


def test_a_scenario_moves_an_arm(tmp_path: Path, capsys: pytest.CaptureFixture[str], mujoco_node: str) -> None:
    assert run(tmp_path, MORE, mujoco_node) == 1  # the cube is released while it should be held
    assert "ur10e has lost 'cube'" in capsys.readouterr().err
    names = {r["id"]: r["name"] for r in read_trace(tmp_path / "trace.jsonl") if r["kind"] == "behavior.start"}
    ended = [
        (names[r["id"]], r["status"])
        for r in read_trace(tmp_path / "trace.jsonl")
        if r["kind"] == "behavior.end" and names[r["id"]].startswith("robot.")
    ]
    assert [end for end in ended if end[1] != "succeeded"] == [
        ("robot.hold", "failed"),
        ("robot.release", "cancelled"),
    ]
    assert len(ended) == 11


@pytest.mark.parametrize(
    ("action", "words"),
    [
        ("robot.grip()", "ur10e closed its gripper but does not hold anything that can be lifted"),
        (
            "robot.move_to_pose(above, namespace_override: 'x')",
            "`namespace_override` cannot be set in a scenario; omit it",
        ),
        ("robot.move_to_joint_pose([0.01, 0.02], move_group: move_group_type!gripper)", "or two equal positions"),
    ],
)
def test_impossible_actions_fail_with_a_reason(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], mujoco_node: str, action: str, words: str
) -> None:
    assert run(tmp_path, action, mujoco_node) == 1
    assert words in capsys.readouterr().err
