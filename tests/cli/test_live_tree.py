"""`seoro exec --live-tree`, in a terminal and without one."""

import fcntl
import os
import pty
import signal
import struct
import subprocess
import sys
import termios
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from seoro.cli.main import main

SCENARIO = """import osc.types
import osc.helpers

scenario main:
    event go
    do parallel:
        serial:
            log("\\033hello")
            wait elapsed({duration})
            emit go
        wait @go
"""
SHOW_CURSOR, HIDE_CURSOR = b"\x1b[?25h", b"\x1b[?25l"


@contextmanager
def in_a_terminal(arguments: list[str], width: int, height: int) -> Iterator[tuple[subprocess.Popen[bytes], int]]:
    """Run the command in an own terminal; yield the process and the file descriptor of the terminal."""
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", height, width, 0, 0))
    environment = {
        name: value for name, value in os.environ.items() if name not in ("NO_COLOR", "COLUMNS", "LINES")
    }
    command = [sys.executable, "-m", "seoro", "exec", *arguments]
    process = subprocess.Popen(
        command, stdin=theirs, stdout=theirs, stderr=theirs, env={**environment, "TERM": "xterm-256color"}
    )
    os.close(theirs)
    try:
        yield process, ours
    finally:
        process.kill()
        process.wait()
        os.close(ours)


def read_until(ours: int, text: bytes | None) -> bytes:
    """Read up to a text, or to the end."""
    found = b""
    while text is None or text not in found:
        try:
            data = os.read(ours, 65536)
        except OSError:  # Linux: the other side is closed
            break
        if not data:
            break
        found += data
    return found


def write(folder: Path, duration: str) -> str:
    (folder / "test.osc").write_text(SCENARIO.replace("{duration}", duration).replace("\\033", "\x1b"))
    return str(folder / "test.osc")


@pytest.mark.parametrize(("width", "height"), [(60, 12), (200, 50), (20, 5)])
def test_the_tree_is_drawn_and_stays(tmp_path: Path, width: int, height: int) -> None:
    with in_a_terminal([write(tmp_path, "300ms"), "-t"], width, height) as (process, ours):
        shown = read_until(ours, None)
        assert process.wait(timeout=20) == 0
    assert b"~ " in shown
    assert b"scenario main" in shown
    assert b"passed" in shown[shown.rindex(SHOW_CURSOR) :]
    assert shown.count(HIDE_CURSOR) == shown.count(SHOW_CURSOR) == 1
    assert b"\x1bhello" not in shown


def test_an_interrupt_leaves_the_terminal_in_order(tmp_path: Path) -> None:
    with in_a_terminal([write(tmp_path, "1h"), "-t"], 80, 24) as (process, ours):
        shown = read_until(ours, b"wait @go")
        process.send_signal(signal.SIGINT)
        shown += read_until(ours, None)
        assert process.wait(timeout=20) == 130
    assert shown.count(HIDE_CURSOR) == shown.count(SHOW_CURSOR) == 1
    assert b"stopping robots" in shown
    assert b"cancelled" in shown[shown.rindex(SHOW_CURSOR) :]


def test_without_a_terminal_lines_are_printed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["exec", write(tmp_path, "0s"), "--live-tree"]) == 0
    out, err = capsys.readouterr()
    assert "passed  main" in out
    assert "\x1b" not in out
    assert err == "note: `--live-tree` needs a terminal; printing line by line instead\n"
