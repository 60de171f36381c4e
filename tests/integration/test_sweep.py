"""Sweeps with simulators."""

import csv
from pathlib import Path

import pytest

from seoro.cli.main import main
from tests.integration.conftest import read_trace

pytestmark = pytest.mark.engine("mujoco")

SCENARIO = """
import osc.nav2

scenario main:
    robot: differential_drive_robot
    x: length
    keep(x in [-0.3m, 0.3m])
    do serial:
        robot.init_nav2(pose_3d(position_3d(x: 0m)))
        robot.nav_to_pose(pose_3d(position_3d(x: x)))
"""
COMMON = ["--sim", "mujoco", "--world", "maze", "--rate", "max", "--seed", "3"]


@pytest.mark.slow
def test_a_run_of_a_sweep_equals_a_single_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Both runs use one simulator in turn; the first does not affect the second."""
    monkeypatch.chdir(tmp_path)
    Path("main.osc").write_text(SCENARIO)
    assert main(["sweep", "main.osc", *COMMON, "--jobs", "1", "-o", "swept"]) == 0
    assert main(["exec", "main.osc", *COMMON, "--set", "x=0.3m", "-o", "alone"]) == 0
    swept, alone = (
        [{**record, "wall": None} for record in read_trace(folder / "trace.jsonl")]
        for folder in (tmp_path / "swept/runs/2", tmp_path / "alone")
    )
    assert swept == alone
    assert Path("swept/runs/2/measurements.json").read_bytes() == Path("alone/measurements.json").read_bytes()
    with Path("swept/results.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["turtlebot4.goals_reached"] for row in rows] == ["1", "1"]
    assert 0.2 < float(rows[0]["turtlebot4.path_length"]) < 0.8
