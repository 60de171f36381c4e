"""Real processes: the command line and simulator nodes."""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.routers import free_endpoint

SCENARIOS = Path(__file__).parents[2] / "scenarios"
OBSTACLE = str(SCENARIOS / "navigation" / "obstacle.osc")
GO_TO_POSE = str(SCENARIOS / "navigation" / "go_to_pose.osc")

StartSeoro = Callable[..., subprocess.Popen[str]]


@pytest.fixture(autouse=True)
def _temporary_files_of_its_own(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Use a folder for temporary files that other processes of the machine do not use."""
    with tempfile.TemporaryDirectory(prefix="own-") as folder:  # short, because socket addresses are limited
        monkeypatch.setenv("TMPDIR", folder)
        monkeypatch.setattr(tempfile, "tempdir", folder)
        yield


@pytest.fixture
def start_seoro() -> Iterator[StartSeoro]:
    """Return a function that starts `seoro`; remaining processes are killed after the test."""
    started: list[subprocess.Popen[str]] = []

    def start(*arguments: str) -> subprocess.Popen[str]:
        process = subprocess.Popen(
            [sys.executable, "-m", "seoro", *arguments],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        started.append(process)
        return process

    yield start
    for process in started:
        if process.poll() is None:
            process.kill()
        process.communicate()


@pytest.fixture(scope="session")
def mujoco_node() -> Iterator[str]:
    """Run one simulator node for many tests; yields its endpoint, for `--connect`."""
    endpoint = free_endpoint()
    command = [sys.executable, "-m", "seoro", "sim", "mujoco", "--listen", endpoint]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as process:
        assert process.stdout is not None
        assert process.stdout.readline(), "the node did not start"
        yield endpoint
        process.terminate()


def read_trace(path: Path) -> list[dict[str, Any]]:
    """Return the records of a trace file."""
    return [json.loads(line) for line in path.read_text().splitlines()]


def wait_until(condition: Callable[[], object], timeout: float) -> None:
    """Wait for an effect of another process, by the wall clock."""
    deadline = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < deadline, f"expected within {timeout} s"
        time.sleep(0.01)


def children(pid: int) -> list[int]:
    """Return the process ids of the children of a process that runs simulator nodes."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdecimal():
            try:
                stat = (entry / "stat").read_text().rpartition(")")[2].split()
                command = (entry / "cmdline").read_bytes()
            except OSError:
                continue
            if int(stat[1]) == pid and b"sim_nodes" in command:
                found.append(int(entry.name))
    return found


def is_alive(pid: int) -> bool:
    """Return whether a process exists and is not a zombie."""
    try:
        os.kill(pid, 0)
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def marked(mark: str) -> set[int]:
    """Return the living processes with a mark, `NAME=value`, in their environment."""
    found = set()
    for entry in Path("/proc").iterdir():
        if entry.name.isdecimal() and is_alive(int(entry.name)):
            try:
                environment = (entry / "environ").read_bytes()
            except OSError:
                continue
            if mark.encode() in environment.split(b"\0"):
                found.add(int(entry.name))
    return found


def wait_for_driving(process: subprocess.Popen[str]) -> int:
    """Wait until a run drives its robot; returns the process id of its simulator node."""
    assert process.stdout is not None
    for line in process.stdout:
        if "> robot.nav_to_pose" in line:
            break
    [node] = children(process.pid)
    return node
