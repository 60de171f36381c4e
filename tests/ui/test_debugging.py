"""Debugger of the pages: a debug adapter for each socket, and its run among the runs of the site."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count
from pathlib import Path
from typing import Any

import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection

from seoro.ui import debug_session, debugging
from tests.ui.browsing import DEADLINE, Browser, next_frame

GOING_AWAY = 1001  # close code
SCENARIO = """import osc.helpers

scenario stepped:
    var count: int = 0
    do serial:
        log("begin")
        increment(count)
        wait elapsed(2s)
        log("end")
"""


@pytest.fixture(scope="module")
def file(folder: Path) -> str:
    (folder / "stepped.osc").write_text(SCENARIO)
    return "stepped.osc"


class Page:
    """The page's side of a session."""

    def __init__(self, socket: ClientConnection) -> None:
        self._socket = socket
        self._numbers = count(1)
        self.seen: list[dict[str, Any]] = []

    def send(self, command: str, **arguments: Any) -> int:
        number = next(self._numbers)
        message = {"seq": number, "type": "request", "command": command, "arguments": arguments}
        self._socket.send(json.dumps(message))
        return number

    def receive(self) -> dict[str, Any]:
        message: dict[str, Any] = json.loads(self._socket.recv(DEADLINE))
        self.seen.append(message)
        return message

    def ask(self, command: str, **arguments: Any) -> dict[str, Any]:
        number = self.send(command, **arguments)
        while (message := self.receive()).get("request_seq") != number:
            assert "error" not in message, message
        return message

    def event(self, name: str) -> dict[str, Any]:
        while (message := self.receive()).get("event") != name:
            pass
        body: dict[str, Any] = message["body"]
        return body

    def launch(self, program: str, **settings: Any) -> dict[str, Any]:
        """Launch a scenario; returns the event with its run."""
        self.ask("initialize", adapterID="seoro")
        answer = self.ask("launch", program=program, sim="", world=None, seed=1, set={}, **settings)
        assert answer["success"], answer
        body: dict[str, Any] = self.seen[-2]["body"]
        assert self.seen[-2]["event"] == "seoro/run"
        return body

    def leave(self) -> None:
        """Close the socket as browsers do when a page is loaded again."""
        self._socket.close(GOING_AWAY)


@contextmanager
def session(browser: Browser, run: str = "") -> Iterator[Page]:
    """Open a session, or return to that of a run."""
    with browser.socket(f"/api/debug?run={run}" if run else "/api/debug") as socket:
        yield Page(socket)


def test_a_page_debugs_a_run_and_follows_its_trace(browser: Browser, file: str, folder: Path) -> None:
    with session(browser) as page:
        found = page.launch(file)
        assert found["program"] == str(folder / file)
        placed = page.ask("setBreakpoints", source={"path": found["program"]}, breakpoints=[{"line": 7}])
        assert placed["body"]["breakpoints"][0]["verified"]
        page.ask("configurationDone")
        assert page.event("stopped")["reason"] == "breakpoint"
        entry = browser.run(lambda run: run["id"] == found["run"])
        assert (entry["status"], entry["place"], entry["file"]) == ("running", "debugger", file)
        with browser.socket(f"/api/run/{found['run']}") as socket:
            frame, _ = next_frame(socket)
            assert frame["first"]
            source = next(each for each in frame["sources"] if each.get("text") == SCENARIO)
            assert source["name"].endswith(file)
            page.ask("continue", threadId=1)
            assert page.event("exited")["exitCode"] == 0
            while frame.get("end") is None:
                frame, _ = next_frame(socket)
        assert frame["end"]["status"] == "passed"
        browser.run(lambda run: run["id"] == found["run"] and run["status"] == "passed")


def test_the_run_ends_when_its_page_ends_the_session(browser: Browser, file: str) -> None:
    with session(browser) as page:
        found = page.launch(file, stopOnEntry=True)
        page.ask("configurationDone")
        page.event("stopped")
    ended = browser.run(lambda run: run["id"] == found["run"] and run["status"] not in ("waiting", "running"))
    assert ended["status"] == "cancelled"


def test_a_page_that_is_loaded_again_goes_on_from_the_present_state(browser: Browser, file: str) -> None:
    with session(browser) as page:
        found = page.launch(file)
        source = {"name": file, "path": found["program"]}
        page.ask(
            "setBreakpoints", source=source, breakpoints=[{"line": 7, "condition": "count == 0"}, {"line": 99}]
        )
        page.ask("configurationDone")
        paused = page.event("stopped")
        page.leave()
    with session(browser, found["run"]) as page:
        assert page.event("stopped") == paused
        run, marks, output, _ = page.seen
        assert run["body"] == found
        assert marks["body"]["source"] == source
        held, refused = marks["body"]["breakpoints"]
        assert (held["line"], held["condition"], held["verified"]) == (7, "count == 0", True)
        assert not refused["verified"]
        assert "begin" in output["body"]["output"]
        frames = page.ask("stackTrace", threadId=paused["threadId"])["body"]["stackFrames"]
        assert page.ask("evaluate", expression="count", frameId=frames[0]["id"])["body"]["result"] == "0"
        page.ask("next", threadId=paused["threadId"])
        page.event("stopped")
        page.send("continue", threadId=1)
        assert page.event("exited")["exitCode"] == 0
    browser.run(lambda run: run["id"] == found["run"] and run["status"] == "passed")
    with session(browser, found["run"]) as page:
        assert page.receive()["error"] == "the debugged run has ended"


def test_answers_to_the_page_before_are_not_sent_to_the_next_one(browser: Browser, file: str) -> None:
    with session(browser) as before:
        found = before.launch(file, stopOnEntry=True)
        before.ask("configurationDone")
        before.event("stopped")
        with session(browser, found["run"]) as page:
            page.event("stopped")
            with pytest.raises(ConnectionClosed) as closed:
                before.receive()
            assert closed.value.rcvd is not None
            assert closed.value.rcvd.code == debug_session.REPLACED
            page.send("continue", threadId=1)
            page.event("terminated")
            answers = [each["command"] for each in page.seen if each["type"] == "response"]
            assert answers == ["continue"]


def test_a_run_to_which_no_page_returns_is_cancelled(
    browser: Browser, file: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    with session(browser) as page:
        found = page.launch(file, stopOnEntry=True)
        page.ask("configurationDone")
        page.event("stopped")
        monkeypatch.setattr(debug_session, "RETURN_WITHIN", 0.0)
        page.leave()
    wait_cancelled(browser, found["run"])
    with session(browser, found["run"]) as page:
        assert page.receive()["error"] == "the debugged run has ended"


def test_an_emergency_stop_ends_debugged_runs(browser: Browser, file: str) -> None:
    with session(browser) as page:
        found = page.launch(file, stopOnEntry=True)
        page.ask("configurationDone")
        page.event("stopped")
        outcomes = browser.post("/api/lab/stop-all", {}).json()["outcomes"]
        try:
            assert {"name": f"the debugged run of {file}", "error": "", "done": "stopped"} in outcomes
            with pytest.raises(ConnectionClosed):
                while True:
                    page.receive()
            browser.run(lambda run: run["id"] == found["run"] and run["status"] == "cancelled")
        finally:
            browser.post("/api/lab/release", {"reason": "the test is over"})


def test_invalid_launches_are_refused(browser: Browser, file: str, folder: Path, tmp_path: Path) -> None:
    (tmp_path / "elsewhere.osc").write_text(SCENARIO)
    (folder / "wrong.osc").write_text("scenario wrong:\n    do serial:\n        fly()\n")
    with session(browser) as page:
        page.ask("initialize")
        for program in (str(tmp_path / "elsewhere.osc"), f"../{tmp_path.name}/elsewhere.osc", ""):
            page.send("launch", program=program)
            assert page.receive()["error"] == "unknown scenario file"
        refused = page.ask("launch", program="wrong.osc")
        assert (refused["success"], refused["message"]) == (False, "unknown scenario or action `fly`")
        assert page.ask("launch", program=file)["success"]
        page.send("launch", program=file)
        while "error" not in (message := page.receive()):
            pass
        assert message["error"] == "the session has a run already"


def test_sessions_are_limited_and_those_without_a_page_give_way(browser: Browser, file: str) -> None:
    end = time.monotonic() + DEADLINE
    while time.monotonic() < end:
        with several(browser, debugging.MOST_SESSIONS) as pages, session(browser) as page:
            if all(map(is_admitted, pages)):
                assert page.receive()["error"] == "too many debugged runs"
                left = pages[0].launch(file, stopOnEntry=True)
                pages[0].ask("configurationDone")
                pages[0].event("stopped")
                pages[0].leave()
                with session(browser) as admitted:
                    assert is_admitted(admitted)
                wait_cancelled(browser, left["run"])
                return
    raise AssertionError("sessions of other tests do not end")


def wait_cancelled(browser: Browser, run: str) -> None:
    """Wait until the site lists a run as cancelled."""
    browser.run(lambda found: found["id"] == run and found["status"] == "cancelled")


def is_admitted(page: Page) -> bool:
    """Return whether a session is open; those of earlier tests may still be ending."""
    try:
        return bool(page.ask("initialize")["success"])
    except (ConnectionClosed, AssertionError):
        return False


@contextmanager
def several(browser: Browser, number: int) -> Iterator[list[Page]]:
    """Open several sessions."""
    if number == 0:
        yield []
        return
    with session(browser) as page, several(browser, number - 1) as others:
        yield [page, *others]
