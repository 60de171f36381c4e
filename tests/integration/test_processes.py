"""However a run ends, nothing is left of the processes that it started."""

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
    """What the environment of all processes of a run has."""
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
    assert wait_until(lambda: len(marked(mark)) == 4, 10)
    process.send_signal(number)
    process.communicate(timeout=10)
    assert process.returncode == code
    assert wait_until(lambda: not marked(mark), 3)


def test_signals_that_are_blocked_where_a_run_is_started_are_not_for_its_processes(
    mark: str, tmp_path: Path, start_seoro: StartSeoro
) -> None:
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGCHLD, signal.SIGTERM})
    try:
        process = start_seoro("exec", str(tmp_path / "main.osc"))
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
    assert wait_until(lambda: len(marked(mark)) == 4, 10)
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=8)  # its processes would be killed after 10 s
    assert process.returncode == 130
    assert not marked(mark)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(12))
def test_a_run_that_is_killed_at_any_moment_leaves_nothing(
    seed: int, mark: str, tmp_path: Path, start_seoro: StartSeoro
) -> None:
    process = start_seoro("exec", str(tmp_path / "main.osc"))
    time.sleep(random.Random(seed).uniform(0.2, 2.0))
    process.kill()
    try:
        process.communicate(timeout=10)  # its keepers hold its output open, until they have ended
    except subprocess.TimeoutExpired:
        pytest.fail("something of it lives on")
    assert wait_until(lambda: not marked(mark) and not keepers(tmp_path), 3)


def keepers(folder: Path) -> list[str]:
    """Process ids of the keepers of programs in a folder."""
    return [entry.name for entry in Path("/proc").iterdir() if _is_keeper_of(entry, folder)]


def _is_keeper_of(process: Path, folder: Path) -> bool:
    try:
        command = (process / "cmdline").read_bytes()
    except OSError:
        return False
    return b"keeper.py" in command and str(folder).encode() in command
