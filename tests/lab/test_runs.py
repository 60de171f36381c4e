"""Runs with a lab: robots behind a bridge, alone and beside a simulator."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from pathlib import Path

import pytest

import seoro
from seoro.runtime.verdict import RunStatus, Verdict
from tests.bridges.robot.conftest import Rails
from tests.sim_nodes.engines import make_engine

ALONE = """import osc.helpers
import osc.robotics
import osc.nav2
import osc.ros

scenario go:
    timeout(10s)
    leader: differential_drive_robot
    do serial:
        leader.init_nav2(pose_3d())
        parallel:
            leader.nav_to_pose(pose_3d(position: position_3d(x: 0.2m)))
            leader.tf_close_to(0.01m, position_3d(x: 0.1m))
"""


def lab_of(folder: Path, text: str) -> seoro.Lab:
    file = folder / "lab.yaml"
    file.write_text(text)
    return seoro.Lab(file)


def run(folder: Path, text: str, lab: seoro.Lab, **options: object) -> Verdict:
    file = folder / "go.osc"
    file.write_text(text)
    return seoro.run(seoro.load(file), lab=lab, **options)  # type: ignore[arg-type]


def floor(rails: Rails, *robots: str) -> str:
    return f"bridges:\n  floor: {{connect: {rails.endpoint}}}\nrobots:\n" + "".join(
        f"  {actor}: {{in: floor, as: {robot}}}\n" for actor, robot in (each.split("=") for each in robots)
    )


def test_a_scenario_runs_on_a_robot_behind_a_bridge(rails: Rails, tmp_path: Path) -> None:
    lab = lab_of(tmp_path, floor(rails, "leader=line"))
    assert run(tmp_path, ALONE, lab).status is RunStatus.PASSED
    assert rails.commands()[-1][2] == 0.0


def test_velocities_are_sent_to_the_bridge_of_their_robot(
    rails: Rails, start_rails: Callable[..., Rails], tmp_path: Path
) -> None:
    other = start_rails("--listen", f"unixsock-stream/{tmp_path}/other", "second")
    lab = f"bridges:\n  floor: {{connect: {rails.endpoint}}}\n  hall: {{connect: {other.endpoint}}}\n"
    lab += "robots:\n  leader: {in: floor, as: line}\n  follower: {in: hall, as: second}\n"
    text = ALONE.partition("    do serial:")[0] + "    follower: differential_drive_robot\n    do serial:\n"
    for robot, speed in (("second", 0.2), ("line", 0.1)):
        twist = f"{{linear: {{x: {speed}}}}}"
        text += f'        topic_publish("/{robot}/cmd_vel", "geometry_msgs.msg.Twist", "{twist}")\n'
    verdict = run(tmp_path, text, lab_of(tmp_path, lab))
    assert verdict.status is RunStatus.PASSED, verdict.reason
    assert [velocity for _, _, velocity in rails.commands() if velocity] == [0.1]
    assert [velocity for _, _, velocity in other.commands() if velocity] == [0.2]


def test_an_impossible_goal_fails_the_run_with_its_reason(rails: Rails, tmp_path: Path) -> None:
    lab = lab_of(tmp_path, floor(rails, "leader=line"))
    verdict = run(tmp_path, ALONE.replace("x: 0.2m", "x: 200m"), lab)
    assert verdict.status is RunStatus.FAILED
    assert "the rails end at 100 m" in verdict.reason


def test_a_robot_that_dies_with_its_bridge_ends_the_run_as_an_error(
    start_rails: Callable[..., Rails], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rails = start_rails("--listen", f"unixsock-stream/{tmp_path}/rails")
    monkeypatch.setattr("seoro.bridges.robot.node.PATIENCE", 0.3)

    class Killer:
        def record(self, record: dict[str, object]) -> None:
            if "nav_to_pose" in str(record.get("name")):
                rails.process.kill()

    lab = lab_of(tmp_path, floor(rails, "leader=line"))
    verdict = run(tmp_path, ALONE, lab, observers=(Killer(),))
    assert verdict.status is RunStatus.ERROR
    assert "rails" in verdict.reason


@pytest.mark.parametrize(
    ("robots", "words"),
    [
        (("leader=train",), r"lab\.yaml:4: robots\.leader: unknown robot 'train' .robots: line. in floor"),
        (("leader=line", "driver=other"), r"lab\.yaml:5: robots\.driver: unknown robot 'other'"),
    ],
)
def test_unknown_robots_are_refused_with_their_names(
    rails: Rails, tmp_path: Path, robots: tuple[str, ...], words: str
) -> None:
    with pytest.raises(seoro.UsageError, match=words):
        run(tmp_path, ALONE, lab_of(tmp_path, floor(rails, *robots)))


def test_mismatches_of_actors_and_robots_are_refused(start_rails: Callable[..., Rails], tmp_path: Path) -> None:
    rails = start_rails("--listen", f"unixsock-stream/{tmp_path}/rails", "line", "second")
    with pytest.raises(seoro.UsageError, match=r"lab\.yaml:5: unknown actor 'driver' in this scenario"):
        run(tmp_path, ALONE, lab_of(tmp_path, floor(rails, "leader=line", "driver=second")))
    actor = ALONE.partition("    timeout")[0] + "    leader: osc_actor\n    do serial:\n        wait elapsed(0s)\n"
    with pytest.raises(
        seoro.UsageError, match=r"lab\.yaml:4: 'line' .* cannot stand for `leader` of the type osc_actor"
    ):
        run(tmp_path, actor, lab_of(tmp_path, floor(rails, "leader=line")))
    with pytest.raises(seoro.UsageError, match="the run has neither a simulator nor a robot"):
        run(tmp_path, ALONE, lab_of(tmp_path, f"bridges:\n  floor: {{connect: {rails.endpoint}}}\n"))


def test_options_that_contradict_a_lab_are_refused(rails: Rails, tmp_path: Path) -> None:
    lab = lab_of(tmp_path, floor(rails, "leader=line"))
    with pytest.raises(seoro.UsageError, match="the clock 'virtual' is impossible with robots"):
        run(tmp_path, ALONE, lab, clock="virtual")
    with pytest.raises(seoro.UsageError, match="invalid rate 2: expected 1"):
        run(tmp_path, ALONE, seoro.Lab(lab.file, rate=2.0))
    with pytest.raises(seoro.UsageError, match="a simulator contradicts a lab"):
        run(tmp_path, ALONE, lab, simulator=seoro.Simulator(name="mujoco"))


MIXED = """import osc.helpers
import osc.robotics
import osc.nav2
import osc.driving

scenario go:
    timeout(20s)
    leader: differential_drive_robot
    follower: differential_drive_robot
    do serial:
        follower.init_nav2(pose_3d())
        parallel:
            leader.nav_to_pose(pose_3d(position: position_3d(x: 0.3m)))
            follower.drive(linear: 0.2mps, duration: 0.5s)
"""


def test_a_run_has_a_robot_in_a_simulator_and_one_behind_a_bridge(rails: Rails, tmp_path: Path) -> None:
    make_engine("mujoco")
    text = f"simulators:\n  sim: {{simulator: mujoco, world: empty}}\n{floor(rails, 'leader=line')}"
    verdict = run(tmp_path, MIXED, lab_of(tmp_path, f"{text}  follower: {{in: sim, as: turtlebot4}}\n"))
    assert verdict.status is RunStatus.PASSED, verdict.reason
    assert rails.commands()[-1][2] == 0.0


class Hang:
    """An observer that blocks the process of the run once a robot drives."""

    def record(self, record: dict[str, object]) -> None:
        if record.get("kind") == "behavior.start" and "nav_to_pose" in str(record.get("name")):
            asyncio.get_running_loop().call_later(0.3, time.sleep, 0.9)


@pytest.mark.parametrize("handler", ["", " with:\n                failure_is_success()"])
def test_a_lost_hold_is_an_error_even_if_the_scenario_handles_failures(
    rails: Rails, tmp_path: Path, handler: str
) -> None:
    text = ALONE.partition("        parallel:")[0]
    text += f"        leader.nav_to_pose(pose_3d(position: position_3d(x: 50m))){handler}\n"
    verdict = run(tmp_path, text, lab_of(tmp_path, floor(rails, "leader=line")), observers=(Hang(),))
    assert verdict.status is RunStatus.ERROR, verdict.reason
    assert "no heartbeat for 0.4 s" in verdict.reason
