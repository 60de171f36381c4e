"""Monitors, conditions and values of measures, in real simulators."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from seoro.cli.main import main

WORLD = """
name: yard
extent: [-3, -2, 9, 2]
props:
  - {name: parcel, cube: 0.3, mass: 1.0, pose: {x: 1.2}}
robots:
  - {name: turtlebot4, robot: turtlebot4}
"""
HEAD = """import osc.driving
import osc.helpers
import osc.measures
import osc.ros
import osc.sim

scenario main:
    robot: differential_drive_robot
    var length_driven: length = 0m
    var touched: int = 0
    record(length_driven, unit: m, event: end)
    do """
PUSH = "robot.drive(linear: 0.3mps, duration: 2s)"
engines = pytest.mark.parametrize("engine", ["mujoco", pytest.param("pybullet", marks=pytest.mark.more)])


def run(folder: Path, body: str, engine: str = "mujoco", *, node: str = "") -> tuple[int, list[dict[str, Any]]]:
    """Return the exit status and trace of a run, on a node if its endpoint is given."""
    world, file, trace = folder / "yard.yaml", folder / "main.osc", folder / "trace.jsonl"
    world.write_text(WORLD)
    file.write_text(HEAD + body + "\n")
    simulator = ("--connect", node) if node else ("--sim", engine)
    command = ["exec", str(file), *simulator, "--world", str(world), "--rate", "max", "--seed", "0"]
    status = main([*command, "--trace", str(trace)])
    return status, [json.loads(line) for line in trace.read_text().splitlines()]


@engines
def test_a_monitor_fails_a_run_in_the_tick_of_the_violation(tmp_path: Path, engine: str) -> None:
    body = f"serial:\n        {PUSH}\n        {PUSH}\n    with:\n        keep_clearance(0.3m)"
    status, records = run(tmp_path, body, engine)
    end = records[-1]
    assert (status, end["status"]) == (1, "failed")
    assert "turtlebot4 has a clearance of 0.2" in end["reason"]
    assert " m to 'parcel' at (0." in end["reason"]
    assert f"{end['duration']:.3f} s after the start; expected more than 0.3 m" in end["reason"]
    assert end["source"].startswith(f"{tmp_path}/main.osc:16") or "main.osc:" in end["source"]


def test_each_monitor_and_condition_acts(tmp_path: Path, mujoco_node: str) -> None:
    """The steps are in one run; each monitor that fails is inverted."""
    failing = [
        "limit_speed(0.2mps)",
        "limit_speed(0.2mps, within: floor_area(x_min: 0.1m), entities: ['turtlebot4'])",
        "stay_in(floor_area(x_max: 0.3m))",
        "keep_out_of(floor_area(x_min: 0.3m))",
        "limit_path_length(0.3m)",
        "limit_time_in(0.5s, within: floor_area(x_min: -1m))",
        "limit_localization_error(0.1m)",
        "limit_work(0.05)",
    ]
    kept = [
        "keep_clearance(1cm)",
        "limit_work(100.0, robots: ['turtlebot4'])",
        "keep_clearance(0.1m, other: 'parcel')",
        "limit_speed(0.4mps)",
        "limit_tilt(5deg)",
        "limit_speed(0.1mps, within: floor_area(x_min: 5m))",
        "limit_speed(1mps, entities: ['parcel'])",
        "stay_in(floor_area(x_max: 3m))",
        "limit_time_in(3s, within: floor_area())",
    ]
    back = "set_entity_state('turtlebot4', pose_3d())"
    moves = [f"{PUSH} with:\n            inverter()\n            {each}" for each in failing]
    several = f"{PUSH} with:\n" + "\n".join(f"            {each}" for each in kept)
    waits = [
        "wait_for_speed('turtlebot4', above: 0.2mps)",
        "wait_for_exit('turtlebot4', within: floor_area(x_max: 0.2m))",
        "wait_for_entry('turtlebot4', within: floor_area(x_min: 0.3m))",
        "wait_for_clearance('turtlebot4', at_most: 0.5m, other: 'parcel')",
        "wait_for_slowness('turtlebot4', at_most: 0.01mps)",
        "store_measurement('turtlebot4', 'path_length', length_driven)",
        "store_measurement('turtlebot4', 'contacts', touched)",
    ]
    serial = "\n                ".join(waits)
    together = f"parallel:\n            {PUSH}\n            serial:\n                {serial}"
    init = "robot.init_nav2(pose_3d(position_3d(x: 0.5m)))"
    steps = [several, back, together, back, init]
    steps += [each for move in moves for each in (move, back)]
    body = "serial:\n        " + "\n        ".join(steps)
    status, records = run(tmp_path, body, node=mujoco_node)
    assert (status, records[-1]["reason"]) == (0, "")
    names = {r["id"]: r["name"] for r in records if r["kind"] == "behavior.start"}
    ends = [(names[r["id"]], r["status"]) for r in records if r["kind"] == "behavior.end"]
    found = [name for name, status in ends if status == "failed"]
    assert found == [each.partition("(")[0] for each in failing]
    (driven,) = [r["value"] for r in records if r["kind"] == "record"]
    assert 1.0 < driven < 2.0


@pytest.mark.parametrize(
    ("body", "reason"),
    [
        (f"{PUSH} with:\n        keep_clearance(0.3m, other: 'tree')", "unknown entity 'tree' to keep clear of"),
        (f"{PUSH} with:\n        keep_clearance(0.3m, robots: ['parcel'])", "unknown robot 'parcel'"),
        ("store_measurement('turtlebot4', 'weight', length_driven)", "unknown measurement 'weight'"),
        ("store_measurement('turtlebot4', 'closest_approach', touched)", "expected a variable of float"),
        ("store_measurement('turtlebot4', 'energy', length_driven)", "'turtlebot4' has no energy yet"),
    ],
)
def test_invalid_measures_fail_with_a_reason(tmp_path: Path, mujoco_node: str, body: str, reason: str) -> None:
    status, records = run(tmp_path, body, node=mujoco_node)
    assert status == 1
    assert reason in records[-1]["reason"]
