"""A search by margin in a simulator."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.cli.main import main
from tests.campaign.test_campaigns import table

WORLD = """name: hall
extent: [-3, -3, 3, 3]
walls:
  - points: [[-2.5, -2.5], [2.5, -2.5], [2.5, 2.5], [-2.5, 2.5], [-2.5, -2.5]]
  - {name: post, center: [1.75, 0.8], size: [0.1, 0.1]}
robots:
  - {name: turtlebot4, robot: turtlebot4}
"""
SCENARIO = """import osc.ros
import osc.driving
import osc.measures

scenario main:
    robot: differential_drive_robot with:
        keep(it.namespace == "turtlebot4")
    pace: speed
    keep(pace in [0.1mps..0.3mps])
    turn: angular_rate
    keep(turn in [-0.8radps..0.8radps])
    ahead: time
    keep(ahead in [1s..4s])
    do serial:
        robot.drive(linear: 0.25mps, duration: ahead)
        robot.drive(linear: pace, angular: turn, duration: 4s)
    with:
        keep_clearance(4cm, "post")
"""
RUNS = 40


@pytest.mark.more
def test_a_search_by_margin_drives_into_a_post_that_random_draws_miss(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("hall.yaml").write_text(WORLD)
    Path("main.osc").write_text(SCENARIO)
    command = [
        "campaign",
        "run",
        "main.osc",
        "--sim",
        "mujoco",
        "--world",
        "hall.yaml",
        "--rate",
        "max",
        "--seed",
        "2",
    ]
    command += ["--runs", str(RUNS), "--until", "first failure", "-j", "2"]
    assert main([*command, "--strategy", "search", "-o", "search"]) == 1
    assert main([*command, "--strategy", "random", "-o", "random"]) == 0
    drawn = [float(row["margin"]) for row in table("random/runs.csv")]
    found = [row for row in table("search/runs.csv") if row["status"] == "failed"]
    assert len(drawn) == RUNS and min(drawn) > 0.0
    assert all(float(row["margin"]) <= 0.0 for row in found)
