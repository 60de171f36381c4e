"""Runs of folders and of executors: the list, their data, and stopping them."""

from __future__ import annotations

import json
import subprocess
import sys
import zlib
from pathlib import Path

import anyio
import pytest
from websockets.exceptions import ConnectionClosed

import seoro
from seoro.ui.server import Served
from tests.executors import LONG, NAME, RunningExecutor
from tests.report.joining import split
from tests.report.traces import many_records, records, write
from tests.ui.browsing import DEADLINE, Browser, next_frame, read_frame


def submitted(lab: RunningExecutor, text: str, folder: Path) -> str:
    """Submit a scenario from elsewhere; returns the id of the run."""
    (folder / "test.osc").write_text(text)

    async def submit() -> str:
        async with seoro.Client(lab.endpoint) as client:
            return (await client.submit(NAME, folder / "test.osc")).id

    return anyio.run(submit)


def test_a_run_in_a_folder_is_listed(browser: Browser, hello: Path) -> None:
    run = browser.run(lambda run: run["folder"] == str(hello) and run["status"] == "passed")
    assert (run["kind"], run["place"], run["scenario"]) == ("folder", "results/hello", "hello")
    assert (run["status"], run["mayStop"]) == ("passed", False)
    assert run["started"] <= run["ended"]


def test_frames_and_blocks_have_the_records_of_a_run(browser: Browser, hello: Path) -> None:
    run = browser.run(lambda run: run["folder"] == str(hello))
    with browser.socket(f"/api/run/{run['id']}") as socket:
        data, columns = next_frame(socket)
        while not data.get("end"):
            data, more = next_frame(socket)
            columns += more
    assert data["end"]["status"] == "passed"
    assert columns
    lines = zlib.decompress(browser.http.get(f"/api/run/{run['id']}/block/0").content).splitlines()
    assert [json.loads(line)["message"] for line in lines if b'"kind": "log"' in line] == ["hello"]
    assert browser.http.get(f"/api/run/{run['id']}/block/99").status_code == 404


def test_a_run_of_an_executor_is_followed_and_stopped(
    browser: Browser, lab: RunningExecutor, tmp_path: Path
) -> None:
    run = "x" + submitted(lab, LONG, tmp_path)
    browser.run(lambda each: each["id"] == run and each["status"] == "running" and each["mayStop"])
    browser.run(lambda each: each["id"] == run and each["scenario"] == "long")
    with browser.socket(f"/api/run/{run}") as socket:
        assert next_frame(socket)[0]["first"]
        assert browser.post(f"/api/run/{run}/stop", {"reason": "enough"}).status_code == 200
        while not (data := next_frame(socket)[0]).get("end"):
            pass
    assert data["end"]["status"] == "cancelled"
    found = browser.run(lambda each: each["id"] == run and each["status"] == "cancelled")
    assert "enough" in found["reason"]


def test_an_active_run_in_a_folder_is_followed_until_it_is_killed(
    browser: Browser, folder: Path, tmp_path: Path
) -> None:
    (tmp_path / "long.osc").write_text(LONG)
    out = folder / "results" / "long"
    command = [sys.executable, "-m", "seoro", "exec", str(tmp_path / "long.osc"), "-o", str(out)]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL) as process:
        try:
            run = browser.run(lambda run: run["folder"] == str(out) and run["status"] == "running")
            with browser.socket(f"/api/run/{run['id']}") as socket:
                while "log" not in next_frame(socket)[0]["counts"]:
                    pass
            answer = browser.post(f"/api/run/{run['id']}/stop")
            assert (answer.status_code, answer.json()["error"]) == (409, "this run was started elsewhere")
        finally:
            process.kill()
    found = browser.run(lambda each: each["id"] == run["id"] and each["status"] == "killed")
    assert "no end" in found["reason"]


def test_frames_wait_for_the_page(browser: Browser, folder: Path) -> None:
    trace = write(folder / "results" / "growing", found := records()[:9])
    listed = browser.run(lambda run: run["folder"] == str(trace.parent))
    assert listed["robots"] == ["tb4"]
    run = listed["id"]
    with browser.socket(f"/api/run/{run}") as slow, browser.socket(f"/api/run/{run}") as quick:
        count = next_frame(quick)[0]["count"]
        assert read_frame(slow)[0]["count"] == count == len(found)
        for number in range(3):
            with trace.open("a") as file:
                file.write(json.dumps({"t": number, "kind": "log", "level": "info", "message": "more"}) + "\n")
            count += 1
            while next_frame(quick)[0].get("count") != count:
                pass
        with pytest.raises(TimeoutError):
            slow.recv(0)
        slow.send("next")
        frame = read_frame(slow)[0]
        assert (frame["first"], frame["count"]) == (False, count)


def test_unknown_runs_are_errors(browser: Browser, served: Served) -> None:
    assert browser.http.get("/api/run/f00/block/0").status_code == 404
    with browser.socket("/api/run/f00") as socket:
        assert json.loads(socket.recv(DEADLINE))["error"] == "unknown run"
        with pytest.raises(ConnectionClosed, match="4404"):
            socket.recv(DEADLINE)


def test_large_frames_come_in_pieces_on_request(
    browser: Browser, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("seoro.ui.feeds.PIECE", 1000)
    trace = write(folder / "results" / "large", found := list(many_records(3_000)))
    run = browser.run(lambda run: run["folder"] == str(trace.parent))["id"]
    with browser.socket(f"/api/run/{run}") as socket:
        pieces: list[bytes] = []
        while not pieces or pieces[-1][0]:
            if pieces:
                with pytest.raises(TimeoutError):
                    socket.recv(0)
                socket.send("next")
            pieces.append(bytes(socket.recv(DEADLINE, decode=False)))
    assert len(pieces) > 10
    assert max(map(len, pieces)) == 1001
    fields, columns = split(b"".join(piece[1:] for piece in pieces))
    assert fields["count"] == len(found)
    assert columns
