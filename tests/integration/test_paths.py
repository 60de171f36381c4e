"""`follow_path` and `patrol` of `osc.driving` on simulator nodes."""

from pathlib import Path

import pytest

from seoro.cli.main import main
from tests.integration.conftest import read_trace

pytestmark = pytest.mark.engine("mujoco")

SCENARIO = """
import osc.driving
import osc.helpers

scenario main:
    timeout(60s)
    robot: differential_drive_robot
    do serial:
        robot.follow_path([position_2d(x: 0.4m), position_2d(x: 0.6m, y: 0.2m)], speed: 0.3mps)
        one_of:
            robot.patrol([position_2d(x: 0m), position_2d(x: 0.5m)])
            wait elapsed(2s)
"""


def test_a_robot_follows_paths_of_a_scenario(tmp_path: Path, mujoco_node: str) -> None:
    (tmp_path / "paths.osc").write_text(SCENARIO)
    options = ["--connect", mujoco_node, "--world", "empty", "--rate", "max", "-o", str(tmp_path)]
    assert main(["exec", str(tmp_path / "paths.osc"), *options]) == 0
    records = read_trace(tmp_path / "trace.jsonl")
    names = {each["id"]: each["name"] for each in records if each["kind"] == "behavior.start"}
    ended = {(names[each["id"]], each["status"]) for each in records if each["kind"] == "behavior.end"}
    assert {("robot.follow_path", "succeeded"), ("robot.patrol", "cancelled")} <= ended
