"""Poses in traces of runs in simulators."""

import math
from pathlib import Path
from typing import Any

import pytest

from seoro.cli.main import main
from tests.integration.conftest import read_trace

pytestmark = pytest.mark.engine("mujoco")

SCENARIO = """
import osc.driving

scenario main:
    robot: differential_drive_robot
    do robot.drive(0.3mps, duration: 2s)
"""


STAMPS = ("seq", "wall", "cause")  # numbers of records, and times of the machine


def traced(folder: Path, node: str, *more: str, text: str = SCENARIO) -> list[dict[str, Any]]:
    (folder / "drive.osc").write_text(text)
    options = ["--connect", node, "--world", "empty", "--rate", "max", "--seed", "1", "-o", str(folder), *more]
    assert main(["exec", str(folder / "drive.osc"), *options]) == 0
    return read_trace(folder / "trace.jsonl")


def test_a_trace_has_the_poses_of_its_run(tmp_path: Path, mujoco_node: str) -> None:
    records = traced(tmp_path, mujoco_node)
    poses = [record for record in records if record["kind"] == "poses"]
    assert [record["time"] for record in poses] == pytest.approx([0.1 * index for index in range(len(poses))])
    assert len(poses) == 21
    assert poses[-1]["entities"]["turtlebot4"][0] == pytest.approx(0.57, abs=0.03)
    assert main(["accept", str(tmp_path / "trace.jsonl"), str(tmp_path / "drive.osc")]) == 0


def test_times_of_poses_do_not_depend_on_the_rate(tmp_path: Path, mujoco_node: str) -> None:
    fast = [record["t"] for record in traced(tmp_path, mujoco_node)]
    paced = [record["t"] for record in traced(tmp_path, mujoco_node, "--rate", "7")]
    assert fast == paced
    assert fast == sorted(fast)


def test_a_trace_has_the_scene_before_the_poses(tmp_path: Path, mujoco_node: str) -> None:
    records = traced(tmp_path, mujoco_node)
    [scene] = [record for record in records if record["kind"] == "scene"]
    assert (scene["seq"], scene["world"], scene["entities"][0]["name"]) == (1, "empty", "turtlebot4")
    assert scene["map"]["width"] > 10


def test_a_run_leaves_a_recording(tmp_path: Path, mujoco_node: str) -> None:
    pytest.importorskip("foxglove", reason="the extra `recording` is not installed")
    reader = pytest.importorskip("mcap.reader")
    traced(tmp_path, mujoco_node)
    with (tmp_path / "recording.mcap").open("rb") as file:
        summary = reader.make_reader(file).get_summary()
    counts = {
        channel.topic: summary.statistics.channel_message_counts.get(number, 0)
        for number, channel in summary.channels.items()
    }
    assert (counts["/tf"], counts["/scene"], counts["/map"]) == (21, 1, 1)
    traced(tmp_path, mujoco_node, "--poses", "0")
    assert not (tmp_path / "recording.mcap").exists()


def test_poses_change_nothing_else(tmp_path: Path, mujoco_node: str) -> None:
    def others(rate: str) -> list[dict[str, Any]]:
        records = traced(tmp_path, mujoco_node, "--poses", rate)
        others = [each for each in records if each["kind"] not in ("scene", "poses")]
        return [{name: value for name, value in each.items() if name not in STAMPS} for each in others]

    assert others("0") == others("25")


def test_a_trace_has_scans_of_lidars_that_nobody_uses(tmp_path: Path, mujoco_node: str) -> None:
    text = SCENARIO.replace("2s", "1s")
    records = traced(tmp_path, mujoco_node, "--world", "maze", "--scans", "2", text=text)
    scans = [record for record in records if record["kind"] == "scan"]
    assert [record["time"] for record in scans] == pytest.approx([0.0, 0.5, 1.0])
    first = scans[0]
    assert (first["entity"], first["sensor"], first["pose"][3:]) == ("turtlebot4", "lidar", [0.0, 0.0, 0.0, 1.0])
    assert len(first["ranges"]) == round(2.0 * math.pi / first["angle_increment"])
    near = [distance for distance in first["ranges"] if distance is not None]
    assert 0.3 < min(near) < 1.0
    assert main(["accept", str(tmp_path / "trace.jsonl"), str(tmp_path / "drive.osc")]) == 0


def test_scans_change_nothing_else(tmp_path: Path, mujoco_node: str) -> None:
    def others(rate: str) -> list[dict[str, Any]]:
        records = traced(tmp_path, mujoco_node, "--scans", rate)
        return [
            {name: value for name, value in each.items() if name not in STAMPS}
            for each in records
            if each["kind"] != "scan"
        ]

    assert others("0") == others("10")


def test_more_scans_than_poses_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "drive.osc").write_text(SCENARIO)
    options = ["--sim", "mujoco", "-o", str(tmp_path / "out"), "--poses", "5", "--scans", "10"]
    assert main(["exec", str(tmp_path / "drive.osc"), *options]) == 2
    assert "invalid rate of scans 10: expected 0 to 5, the rate of poses" in capsys.readouterr().err


def test_a_rate_that_no_node_has_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["exec", "drive.osc", "--poses", "51"])
    assert "expected a number from 0 to 50" in capsys.readouterr().err
