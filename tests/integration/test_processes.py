"""Ends of the processes of a run, after each kind of end."""

import random
import signal
import subprocess
import time
from pathlib import Path

import pytest

from tests.integration.conftest import StartSeoro, marked, wait_until

SCENARIO = """
import osc.types
import osc.helpers

scenario main:
    do parallel:
        run_process("{forks}", wait_for_shutdown: false)
        run_process("{forks}")
        serial:
            run_process("sh -c 'sleep 1000 & true'")
            wait elapsed(1h)
"""
FORKS = """#!/bin/sh
export MARK={mark}
(setsid sleep 1000 &)
sleep 1000 &
echo ready
wait
"""


@pytest.fixture
def mark(tmp_path: Path) -> str:
    """Return the mark in the environment of all processes of a run."""
    (tmp_path / "forks").write_text(FORKS.format(mark=tmp_path))
    (tmp_path / "forks").chmod(0o755)
    (tmp_path / "main.osc").write_text(SCENARIO.format(forks=tmp_path / "forks"))
    return f"MARK={tmp_path}"


@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 4), (signal.SIGKILL, -signal.SIGKILL)]
)
def test_a_signal_ends_all_processes_of_a_run(
    number: int, code: int, mark: str, tmp_path: Path, start_seoro: StartSeoro
) -> None:
    process = start_seoro("exec", str(tmp_path / "main.osc"))
    wait_until(lambda: len(marked(mark)) == 4, 30.0)
    process.send_signal(number)
    process.communicate(timeout=30)
    assert process.returncode == code
    wait_until(lambda: not marked(mark), 3)


def test_processes_of_a_run_do_not_inherit_blocked_signals(
    mark: str, tmp_path: Path, start_seoro: StartSeoro
) -> None:
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGCHLD, signal.SIGTERM})
    try:
        process = start_seoro("exec", str(tmp_path / "main.osc"))
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
    wait_until(lambda: len(marked(mark)) == 4, 30.0)
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=8)  # its processes would be killed after 10 s
    assert process.returncode == 130
    assert not marked(mark)


@pytest.mark.more
@pytest.mark.parametrize("seed", range(12))
def test_a_killed_run_leaves_no_processes(seed: int, mark: str, tmp_path: Path, start_seoro: StartSeoro) -> None:
    process = start_seoro("exec", str(tmp_path / "main.osc"))
    time.sleep(random.Random(seed).uniform(0.2, 2.0))
    process.kill()
    try:
        process.communicate(timeout=30)  # its supervisors hold its output open, until they have ended
    except subprocess.TimeoutExpired:
        pytest.fail("something of it lives on")
    wait_until(lambda: not marked(mark) and not supervisors(tmp_path), 3)


def supervisors(folder: Path) -> list[str]:
    """Return the process ids of the supervisors of programs in a folder."""
    return [entry.name for entry in Path("/proc").iterdir() if _is_supervisor_of(entry, folder)]


def _is_supervisor_of(process: Path, folder: Path) -> bool:
    try:
        command = (process / "cmdline").read_bytes()
    except OSError:
        return False
    return b"supervisor.py" in command and str(folder).encode() in command
