"""Actions of `osc.ros` that run programs of ROS 2; here `ros2` prints its arguments."""

import os
from pathlib import Path

import pytest

from seoro.runtime.verdict import RunStatus
from tests.runtime.conftest import RunText

HEADER = "import osc.ros\n"


@pytest.fixture
def ros2(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program = tmp_path / "bin" / "ros2"
    program.parent.mkdir()
    program.write_text('#!/bin/sh\necho "args: $*"\ncase "$3" in *endless*) exec sleep 60;; esac\n')
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{program.parent}{os.pathsep}{os.environ['PATH']}")


@pytest.mark.usefixtures("ros2")
async def test_programs_are_run_and_launched(run_text: RunText) -> None:
    ran = await run_text(
        HEADER
        + """
scenario main:
    do serial:
        ros_run("demo_nodes", "talker")
        ros_launch("nav2_bringup", "bringup.py", [key_value("use_sim_time", "true"), key_value("map", "a b")])
        launched: ros_launch("nav2_bringup", "endless.py", wait_for_shutdown: false)
        process_log_check("launched", ["endless.py"])
"""
    )
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason
    assert [text for _, text in ran.logs] == [
        "args: run demo_nodes talker",
        "args: launch nav2_bringup bringup.py use_sim_time:=true map:=a b",
        "args: launch nav2_bringup endless.py",
    ]


@pytest.mark.parametrize(
    ("invocation", "reason"),
    [
        ('ros_run("demo", "")', "invalid command"),
        ('ros_run("demo", "--help")', "invalid command"),
        ('ros_launch("demo", "a.py", [key_value("a:=b")])', "invalid name of a launch argument: `a:=b`"),
        ('ros_run("demo", "talker")', "ROS 2 not found: `ros2` is not in the folders of `PATH`"),
    ],
)
async def test_commands_that_cannot_run_are_reported(
    invocation: str, reason: str, run_text: RunText, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", "/nowhere")
    ran = await run_text(f"{HEADER}scenario main:\n    do {invocation}\n")
    assert ran.verdict.status is RunStatus.FAILED
    assert reason in ran.verdict.reason
