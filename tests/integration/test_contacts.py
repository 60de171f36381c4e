"""Verdicts of runs in which robots touch entities, in real simulators."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from seoro.cli.main import main

WORLD = """
name: parcels
extent: [-3, -2, 9, 2]
props:
  - {name: parcel, cube: 0.5, mass: 1.0, friction: 0.3, pose: {x: 0.6}}
robots:
  - {name: turtlebot4, robot: turtlebot4}
"""
HEAD = """import osc.driving
import osc.helpers
import osc.ros
import osc.sim

scenario main:
    robot: differential_drive_robot
    do """
PUSH = "robot.drive(linear: 0.3mps, duration: 2s)"
engines = pytest.mark.parametrize("engine", ["mujoco", pytest.param("pybullet", marks=pytest.mark.more)])


def run(folder: Path, body: str, *simulator: str) -> tuple[int, list[dict[str, Any]]]:
    """Return the exit status and trace of a run in a simulator, which two arguments of `exec` name."""
    world, file, trace = folder / "parcels.yaml", folder / "main.osc", folder / "trace.jsonl"
    world.write_text(WORLD)
    file.write_text(HEAD + body + "\n")
    command = ["exec", str(file), *simulator, "--world", str(world), "--rate", "max", "--seed", "0"]
    status = main([*command, "--trace", str(trace)])
    return status, [json.loads(line) for line in trace.read_text().splitlines()]


@pytest.mark.more
@engines
def test_an_action_that_moves_the_robot_into_an_obstacle_fails(
    tmp_path: Path, engine: str, capsys: pytest.CaptureFixture[str]
) -> None:
    status, records = run(tmp_path, PUSH, "--sim", engine)
    [event] = [r for r in records if r["kind"] == "event" and r["name"] == "contact"]
    contact, end = event["arguments"], records[-1]
    assert any(r.get("cause") == event["seq"] for r in records if r["kind"] == "behavior.end")
    assert (status, contact["strikers"]) == (1, ["turtlebot4"])
    assert "turtlebot4 moved into 'parcel' at (0.3" in end["reason"]
    assert f"{contact['time']:.3f} s after the start" in end["reason"]
    assert end["duration"] == contact["time"], "it fails in the step of the contact"
    assert "turtlebot4 moves into parcel" in capsys.readouterr().out


def test_contacts_are_allowed_and_forbidden_by_actions(tmp_path: Path, mujoco_node: str) -> None:
    """The steps are in one run; each fails as its comment states."""
    allowed = [
        f"{PUSH} with:\n            allow_contact(['parcel'])",
        f"{PUSH} with:\n            allow_contact()",
    ]
    blocks = [
        f"serial:\n            {PUSH}\n        with:\n            forbid_contact(allowed: ['parcel'])",
        f"serial:\n            {allowed[0].replace('            allow', '                allow')}\n"
        "        with:\n            forbid_contact()",
    ]
    failing = [
        f"{PUSH} with:\n            allow_contact(['box'])\n            inverter()",
        "serial:\n            topic_publish('/cmd_vel', 'geometry_msgs.msg.Twist', '{linear: {x: 0.3}}')\n"
        "            wait elapsed(0.4s)\n        with:\n            inverter()\n            forbid_contact()",
    ]
    steps = [*allowed, *blocks, *failing]
    body = "serial:\n        " + "\n        ".join(steps)
    status, records = run(tmp_path, body, "--connect", mujoco_node)
    assert (status, records[-1]["reason"]) == (0, "")
    names = {r["id"]: r["name"] for r in records if r["kind"] == "behavior.start"}
    ends = [(names[r["id"]], r["status"]) for r in records if r["kind"] == "behavior.end"]
    assert [status for name, status in ends if name.startswith("forbid_contact")] == [
        "succeeded",
        "succeeded",
        "failed",
    ]


def test_forbidden_contacts_have_the_closest_approach_as_margin(tmp_path: Path, mujoco_node: str) -> None:
    near = PUSH.replace("2s", "0.3s")
    near = f"serial:\n            {near}\n        with:\n            forbid_contact()"
    touch = f"serial:\n            {PUSH}\n        with:\n            inverter()\n            forbid_contact()"
    other = near.replace("forbid_contact()", "forbid_contact(allowed: ['parcel'])")
    body = "serial:\n        " + "\n        ".join((near, other, touch))
    status, records = run(tmp_path, body, "--connect", mujoco_node)
    margins = [(r["check"], r.get("entity"), r["value"]) for r in records if r["kind"] == "margin"]
    assert status == 0 and [each[:2] for each in margins] == [
        ("forbid_contact", "turtlebot4"),
        ("forbid_contact", None),
    ]
    assert 0.05 < margins[0][2] < 0.2 and margins[1][2] == 0.0


def test_a_struck_standing_robot_does_not_fail(tmp_path: Path, mujoco_node: str) -> None:
    strike = (
        "set_entity_state('parcel', pose_3d(position_3d(x: 0.5m, z: 0.251m)), "
        "velocity_6d(translational_velocity_3d(x: -2mps)))"
    )
    stand = "robot.drive(linear: 0mps, duration: 1s)"
    status, records = run(tmp_path, f"parallel:\n        {stand}\n        {strike}", "--connect", mujoco_node)
    contacts = [r["arguments"] for r in records if r["kind"] == "event" and r["name"] == "contact"]
    assert (status, contacts[0]["strikers"]) == (0, ["parcel"])
    also = f"parallel:\n        {stand}\n        {strike}\n    with:\n        forbid_contact(also_struck: true)"
    status, records = run(tmp_path, also, "--connect", mujoco_node)
    assert status == 1
    assert "turtlebot4 was struck by 'parcel'" in records[-1]["reason"]


def test_watching_an_unknown_robot_fails(tmp_path: Path, mujoco_node: str) -> None:
    body = f"{PUSH} with:\n        forbid_contact(['tb5'])"
    status, records = run(tmp_path, body, "--connect", mujoco_node)
    assert status == 1
    assert "unknown robot 'tb5' (robots of this run: turtlebot4)" in records[-1]["reason"]
