"""`osc.mobile_manipulation` on simulator nodes."""

from pathlib import Path

import pytest

from seoro.cli.main import main
from tests.integration.conftest import read_trace
from tests.sim_nodes.manipulation.test_mobile_manipulators import own_arm

pytestmark = pytest.mark.engine("mujoco")

SCENARIO = """
import osc.driving
import osc.helpers
import osc.mobile_manipulation

scenario main:
    timeout(30s)
    mine: mobile_manipulator
    do serial:
        parallel:
            mine.drive(linear: 0.3mps, duration: 2s)
            mine.arm.move_to_joint_pose(
                [0.1, -0.5, 0.8], move_group_type!arm, tolerance: 0.01, max_velocity_scaling_factor: 0.5)
        mine.arm.wait_for_joint('upper_joint', -0.5rad)
"""


def test_a_scenario_drives_a_base_and_moves_its_arm(tmp_path: Path, mujoco_node: str) -> None:
    world, scenario, trace = own_arm(tmp_path), tmp_path / "s.osc", tmp_path / "t.jsonl"
    scenario.write_text(SCENARIO)
    options = ["--connect", mujoco_node, "--world", world, "--rate", "max", "--trace", str(trace)]
    assert main(["exec", str(scenario), *options]) == 0
    ended = [each for each in read_trace(trace) if each["kind"] == "behavior.end"]
    assert all(each["status"] == "succeeded" for each in ended)
