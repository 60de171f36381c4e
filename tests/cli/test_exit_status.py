"""`seoro exec` as a process: exit statuses, and no unrequested traceback."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

LIBRARY = """from pathlib import Path
import asyncio
import time
from seoro import ActionContext, ActionFailed, action

{at_import}

@action("work")
async def work(ctx: ActionContext, how: str) -> None:
    if how == "fail":
        raise ActionFailed("no use")
    if how == "break":
        raise KeyError("bug")
    try:
        Path("begun").touch()
        await ctx.sleep(3600)
    finally:
        if how == "hang":
            await asyncio.sleep(3600)
        Path("cleaned").touch()
"""
SCENARIO = """import osc.own
scenario main:
    how: string = "last"
    do work(how: how)
"""
LOADING = "Path('begun').touch()\ntime.sleep(60)"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "main.osc").write_text(SCENARIO)
    (tmp_path / "seoro.libraries").mkdir()
    (tmp_path / "seoro.libraries" / "own.osc").write_text("action work:\n    how: string\n")
    write_library(tmp_path)
    return tmp_path


def write_library(folder: Path, at_import: str = "") -> None:
    (folder / "seoro.libraries" / "own.py").write_text(LIBRARY.replace("{at_import}", at_import))


@pytest.fixture
def started() -> Iterator[list[subprocess.Popen[str]]]:
    """Processes, which are killed after the test if they are still there."""
    processes: list[subprocess.Popen[str]] = []
    yield processes
    for process in processes:
        process.kill()
        process.communicate()


def start(folder: Path, *arguments: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "seoro", "exec", "main.osc", *arguments]
    return subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


@pytest.mark.parametrize(
    ("arguments", "status", "message"),
    [
        (("--set", 'how="fail"'), 1, "no use"),
        (("--set", "how=3"), 2, "error["),
        (("--set", 'how="break"'), 3, "`work` raised KeyError: 'bug'"),
        (("--timeout", "0.1"), 3, "no verdict within 0.1 s of wall time"),
    ],
)
def test_each_end_has_its_status(folder: Path, arguments: tuple[str, ...], status: int, message: str) -> None:
    process = start(folder, *arguments)
    _, err = process.communicate(timeout=30)
    assert process.returncode == status
    assert message in err
    assert "Traceback" not in err


def test_debug_option_shows_the_traceback_of_a_fault(folder: Path) -> None:
    _, err = start(folder, "--set", 'how="break"', "--debug").communicate(timeout=30)
    assert err.index("main.osc:4:8") < err.index("Traceback") < err.index('raise KeyError("bug")')


@pytest.mark.parametrize(("number", "status"), [(signal.SIGTERM, 4), (signal.SIGHUP, 4), (signal.SIGINT, 130)])
@pytest.mark.parametrize("moment", ["loading", "running"])
def test_a_signal_ends_the_command_in_order(
    folder: Path, started: list[subprocess.Popen[str]], number: signal.Signals, status: int, moment: str
) -> None:
    if moment == "loading":
        write_library(folder, LOADING)
    process = start(folder)
    started.append(process)
    wait_for(folder / "begun")
    process.send_signal(number)
    _, err = process.communicate(timeout=30)
    assert process.returncode == status
    assert "Traceback" not in err
    assert (folder / "cleaned").exists() == (moment == "running")


def test_a_second_signal_waits_for_no_clean_up(folder: Path, started: list[subprocess.Popen[str]]) -> None:
    process = start(folder, "--set", 'how="hang"')
    started.append(process)
    wait_for(folder / "begun")
    process.send_signal(signal.SIGTERM)
    assert process.stdout is not None
    while "press again to stop at once" not in process.stdout.readline():
        pass
    process.send_signal(signal.SIGTERM)
    out, _ = process.communicate(timeout=30)
    assert process.returncode == 4
    assert "longer than allowed" not in out, "it waited for the end of the clean-up"


STUBBORN = """import osc.helpers
scenario stubborn:
    do run_process(command: "{python} program.py", shutdown_timeout: 50s)
"""
PROGRAM = """import os, signal, time
for number in (signal.SIGTERM, signal.SIGINT):
    signal.signal(number, signal.SIG_IGN)
with open("pids.part", "w") as file:
    file.write(f"{os.getpid()} {os.getppid()}")
os.rename("pids.part", "pids")
time.sleep(60)
"""


def test_a_second_signal_kills_programs_and_their_watchers(
    tmp_path: Path, started: list[subprocess.Popen[str]]
) -> None:
    (tmp_path / "main.osc").write_text(STUBBORN.format(python=sys.executable))
    (tmp_path / "program.py").write_text(PROGRAM)
    process = start(tmp_path)
    started.append(process)
    wait_for(tmp_path / "pids")
    process.send_signal(signal.SIGTERM)
    assert process.stdout is not None
    while "press again to stop at once" not in process.stdout.readline():
        pass
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=30)
    left = [pid for pid in (tmp_path / "pids").read_text().split() if Path(f"/proc/{pid}").exists()]
    assert (process.returncode, left) == (4, [])


def wait_for(path: Path) -> None:
    """Wait until another process has made a file."""
    deadline = time.monotonic() + 30
    while not path.exists():
        assert time.monotonic() < deadline
        time.sleep(0.01)
