"""`seoro ui` as a process: its executor, its examples, its end, and its errors."""

from __future__ import annotations

import json
import os
import re
import select
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx
import pytest

from seoro.cli.main import main
from seoro.ui.private_executor import SHOWN
from seoro.ui.security import Access
from tests.executors import LONG
from tests.ui.browsing import DEADLINE, Browser

URL = re.compile(r"http://127\.0\.0\.1:(\d+)/\?token=(\S+)\n")


@contextmanager
def command(folder: Path, *arguments: str) -> Iterator[tuple[Browser, subprocess.Popen[str]]]:
    """Start `seoro ui`, and open its URL."""
    environment = {**os.environ, "XDG_STATE_HOME": str(folder / "state")}
    environment.pop("SEORO_EXECUTOR", None)
    line = [sys.executable, "-m", "seoro", "ui", *arguments, "--port", "0"]
    with subprocess.Popen(line, stdout=subprocess.PIPE, text=True, env=environment, cwd=folder) as process:
        try:
            assert process.stdout is not None
            found = URL.fullmatch(process.stdout.readline())
            assert found is not None
            access = Access("http", ("127.0.0.1",), int(found[1]), found[2])
            with httpx.Client(base_url=access.url.partition("/?")[0], timeout=DEADLINE) as client:
                assert client.get(access.url).status_code == 303
                yield Browser(access, client), process
        finally:
            process.kill()


def test_a_site_has_its_own_executor_and_ends_it(tmp_path: Path) -> None:
    (tmp_path / "long.osc").write_text(LONG)
    unused = f"unixsock-stream/{tmp_path}/nobody"
    with command(tmp_path, "--connect", unused) as (browser, process):
        places = browser.wait_for("/api/site", lambda site: site["mayStart"])["places"]
        assert [(each["name"], each["kind"], bool(each["problem"])) for each in places] == [
            (unused, "executor", True),
            (SHOWN, "executor", False),
            (str(tmp_path), "folder", False),
        ]
        form = {"file": "long.osc", "scenario": "long", "place": SHOWN}
        run = browser.post("/api/start", form).json()["run"]
        browser.run(lambda each: each["id"] == run and each["status"] == "running")
        children = _children(process.pid)
        assert children
        process.send_signal(signal.SIGINT)
        assert process.wait(DEADLINE) == 0
    assert not [child for child in children if Path(f"/proc/{child}").exists()]
    with command(tmp_path, "--connect", unused) as (browser, _):
        again = browser.run(lambda each: each["id"] == run)  # runs of earlier sites
        assert (again["scenario"], again["status"]) == ("long", "cancelled")
    [trace] = (tmp_path / "state").rglob("trace.jsonl")
    assert json.loads(trace.read_text().splitlines()[-1])["status"] == "cancelled"


def test_the_executor_ends_with_a_killed_site(tmp_path: Path) -> None:
    with command(tmp_path, "--connect", f"unixsock-stream/{tmp_path}/nobody") as (browser, process):
        browser.wait_for("/api/site", lambda site: site["mayStart"])
        [executor] = _children(process.pid)
        descriptor = os.pidfd_open(executor)
        try:
            process.kill()
            assert select.select([descriptor], [], [], DEADLINE)[0], "it ended"
        finally:
            os.close(descriptor)


@pytest.mark.more
@pytest.mark.engine("mujoco")
def test_the_demo_shows_a_moving_robot(tmp_path: Path) -> None:
    with command(tmp_path, "--demo") as (browser, _):
        run = browser.run(lambda each: each["scenario"] == "around_a_box" and each["status"] == "running")
        assert browser.get("/api/site")["demo"]
        with browser.socket(f"/api/run/{run['id']}") as opened:
            names: list[str] = []
            while "turtlebot4" not in names:
                names += [each["name"] for each in browser.frame(opened).get("entities", [])]
        browser.run(lambda each: each["scenario"] == "late_parcel" and each["status"] == "failed")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nothing"], "nothing does not exist"),
        (["file.txt"], "file.txt is not a folder"),
        (["--demo", "."], "`--demo` shows its own folder"),
        (["--port", "70000"], "expected a port from 0 to 65535"),
    ],
)
def test_invalid_arguments_are_one_error(
    arguments: list[str],
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file.txt").touch()
    try:
        status = main(["ui", "--port", "0", *arguments])
    except SystemExit as error:
        status = int(str(error.code))
    assert status == 2
    assert message in capsys.readouterr().err


def test_a_port_in_use_is_one_error(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        assert main(["ui", str(tmp_path), "--port", str(port)]) == 2
    error = capsys.readouterr().err
    assert error == f"error: port {port} is in use\n  = help: choose another one, or 0 for a free one\n"


def _children(process: int) -> list[int]:
    found = Path(f"/proc/{process}/task/{process}/children").read_text().split()
    return [int(each) for each in found]
