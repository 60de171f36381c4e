"""Runs in exceptional conditions: each ends as documented, with a clear message, and cleans up."""

import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pytest

from seoro.cli.main import main
from seoro.runtime.execution.outputs import INDEX
from tests.full_disk import run_on_full_disk
from tests.integration.conftest import StartSeoro, children, is_alive, read_trace, wait_until

pytestmark = pytest.mark.engine("mujoco")

DRIVE = """
import osc.driving
import osc.helpers

scenario main:
    robot: differential_drive_robot
    do serial:
        log("off")
        robot.drive(linear: 0.2mps, duration: 2s)
        log("there")
"""

WORLD = """name: hall
extent: [-3, -3, 3, 3]
walls:
  - points: [[-2, -2], [2, -2]]
robots:
  - name: turtlebot4
    robot: turtlebot
"""


def driving(start_seoro: StartSeoro, folder: Path) -> tuple[subprocess.Popen[str], int]:
    """Start a real-time run with a driving robot; return its process and that of its simulator."""
    file = folder / "drive.osc"
    file.write_text(DRIVE)
    process = start_seoro("exec", str(file), "--sim", "mujoco", "--world", "empty", "-o", str(folder / "out"))
    assert process.stdout is not None
    for line in process.stdout:
        if "> robot.drive" in line:
            break
    [node] = children(process.pid)
    return process, node


def stopped_for(start_seoro: StartSeoro, folder: Path, seconds: float) -> tuple[int, str]:
    """Suspend the simulator of a run for a duration; return exit status and output."""
    process, node = driving(start_seoro, folder)
    os.kill(node, signal.SIGSTOP)
    try:
        time.sleep(seconds)
    finally:
        if is_alive(node):
            os.kill(node, signal.SIGCONT)
    _, err = process.communicate(timeout=30)
    wait_until(lambda: not is_alive(node), 30.0)
    return process.returncode, err


@pytest.mark.more
def test_a_run_waits_for_a_suspended_simulator(start_seoro: StartSeoro, tmp_path: Path) -> None:
    assert stopped_for(start_seoro, tmp_path, 2.5) == (0, "")
    ended = [r for r in read_trace(tmp_path / "out" / "trace.jsonl") if r["kind"] == "run.end"]
    assert [r["t"] for r in ended] == [2.0], "time has passed that the simulator has not simulated"


@pytest.mark.more
def test_a_run_waits_for_ten_seconds_at_most(start_seoro: StartSeoro, tmp_path: Path) -> None:
    assert stopped_for(start_seoro, tmp_path, 10.0) == (0, "")


@pytest.mark.more
def test_a_hanging_simulator_ends_the_run(start_seoro: StartSeoro, tmp_path: Path) -> None:
    status, err = stopped_for(start_seoro, tmp_path, 24.0)
    assert status == 3
    assert "the connection to simulator 'mujoco' was lost" in err
    assert read_trace(tmp_path / "out" / "trace.jsonl")[-1]["status"] == "error"


@pytest.mark.more
@pytest.mark.parametrize(
    ("size", "words", "left"),
    [
        pytest.param(
            3_000,
            "cannot write the trace to {}/trace.jsonl: File too large",
            ["trace.jsonl"],
            marks=pytest.mark.more,
        ),
        (20_000, "cannot write {}/top_down.png: File too large; the run itself: passed", ["trace.jsonl"]),
    ],
)
def test_a_full_disk_ends_the_run_as_an_error(tmp_path: Path, size: int, words: str, left: list[str]) -> None:
    file, out = tmp_path / "drive.osc", tmp_path / "out"
    file.write_text(DRIVE)
    command = [sys.executable, "-m", "seoro", "exec", str(file), "--sim", "mujoco", "--rate", "max"]
    ended = run_on_full_disk([*command, "-o", str(out)], size)
    assert ended.returncode == 3
    assert words.format(out) in ended.stderr
    assert "Traceback" not in ended.stderr
    found = {path.name for path in out.iterdir() if path.suffix != ".json"}
    assert sorted(found - {INDEX}) == left


def test_an_invalid_world_file_is_refused_with_its_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, world = tmp_path / "drive.osc", tmp_path / "hall.yaml"
    file.write_text(DRIVE)
    world.write_text(WORLD)
    others = children(os.getpid())  # kept by fixtures of other tests
    assert main(["exec", str(file), "--sim", "mujoco", "--world", str(world)]) == 2
    err = capsys.readouterr().err
    assert f"{world}:7: robots.0.robot: unknown kind of robot 'turtlebot' (kinds:" in err
    assert children(os.getpid()) == others


@pytest.mark.parametrize(
    ("action", "words"),
    [
        ("box.spawn(pose_3d(), 'example_simulation://models/none.sdf')", "none.sdf"),
        pytest.param(
            "box.spawn(pose_3d(), 'file:///nowhere/none.sdf')", "/nowhere/none.sdf", marks=pytest.mark.more
        ),
        pytest.param(
            "robot.nav_to_pose(pose_3d(position_3d(x: 50m)))",
            "goal (50.00, 0.00) is outside of the map",
            marks=pytest.mark.more,
        ),
        pytest.param(
            "robot.nav_to_pose(pose_3d(position_3d(x: 0m * (1.0e308 * 10.0))))",
            "expected numbers within 1000 m",
            marks=pytest.mark.more,
        ),
        ("robot.drive(linear: 0mps * (1.0e308 * 10.0), duration: 1s)", "expected finite numbers"),
    ],
)
def test_impossible_requests_fail_with_a_reason_and_clean_up(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], action: str, words: str
) -> None:
    file = tmp_path / "wrong.osc"
    file.write_text(
        "import osc.driving\nimport osc.nav2\nimport osc.gazebo\nscenario main:\n"
        "    robot: differential_drive_robot\n    box: osc_actor\n    do serial:\n"
        f"        robot.init_nav2(pose_3d())\n        {action}\n"
    )
    others = children(os.getpid())
    assert main(["exec", str(file), "--sim", "mujoco", "--world", "empty", "--rate", "max"]) == 1
    err = capsys.readouterr().err
    assert words in err
    assert f"{file}:9:9" in err
    assert children(os.getpid()) == others
    assert list(Path(tempfile.gettempdir()).iterdir()) == []
