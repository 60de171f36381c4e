"""A debugging session as an editor has it: requests, events, and invalid messages."""

from __future__ import annotations

import asyncio
import json
import subprocess
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from itertools import count
from pathlib import Path
from typing import Any

import pytest

from seoro.dap.connection import Connection, InvalidMessage
from seoro.dap.session import Session

REACTING = """scenario main:
    event done
    event seen
    on @done:
        emit seen
    do serial:
        emit done
"""
SCENARIO = """import osc.helpers

struct point:
    x: int = 3

scenario part:
    level: int = 7
    do serial:
        wait elapsed(1s)
        log("in part")

scenario main:
    where: point
    var count: int = 0
    do serial:
        log("begin")
        parallel:
            part()
            serial:
                increment(count)
                wait elapsed(2s)
                increment(count)
        log("end")
"""


def line_of(text: str) -> int:
    """Return the line of a text in the scenario."""
    return next(number for number, line in enumerate(SCENARIO.split("\n"), 1) if text in line)


class Pipe:
    """Stream into a reader in the same process."""

    def __init__(self, reader: asyncio.StreamReader) -> None:
        self._reader = reader

    def write(self, data: bytes) -> None:
        self._reader.feed_data(data)

    async def drain(self) -> None:
        await asyncio.sleep(0)


class Editor:
    """The other side of a session.

    Attributes:
        events: Events that were received, in order.
    """

    def __init__(self, here: asyncio.StreamReader, there: asyncio.StreamReader) -> None:
        self._connection = Connection(here, Pipe(there))
        self.there = there
        self._numbers = count(1)
        self.events: list[dict[str, Any]] = []
        self.seen: list[dict[str, Any]] = []  # all messages

    async def ask(self, command: str, **arguments: Any) -> dict[str, Any]:
        """Send a request, and return its answer."""
        number = next(self._numbers)
        self.send({"seq": number, "type": "request", "command": command, "arguments": arguments})
        while True:
            message = await self._receive()
            if message.get("request_seq") == number:
                return message
            self.events.append(message)

    async def body(self, command: str, **arguments: Any) -> dict[str, Any]:
        """Send a request, and return the body of its successful answer."""
        answer = await self.ask(command, **arguments)
        assert answer["success"], answer
        body: dict[str, Any] = answer["body"]
        return body

    def send(self, message: dict[str, Any]) -> None:
        data = json.dumps(message).encode()
        self.there.feed_data(b"Content-Length: %d\r\n\r\n%s" % (len(data), data))

    async def event(self, name: str) -> dict[str, Any]:
        """Wait for an event, and return its body."""
        while True:
            for number, message in enumerate(self.events):
                if message.get("event") == name:
                    del self.events[: number + 1]
                    body: dict[str, Any] = message["body"]
                    return body
            self.events.append(await self._receive())

    async def _receive(self) -> dict[str, Any]:
        async with asyncio.timeout(30):
            message = await self._connection.receive()
        assert message is not None
        self.seen.append(message)
        return message

    async def launch(self, file: Path, *lines: int, **settings: Any) -> dict[str, Any]:
        """Initialize, launch and set breakpoints; return the answer to the last."""
        await self.body("initialize", adapterID="seoro")
        await self.body("launch", program=str(file), **settings)
        await self.event("initialized")
        wanted = [{"line": line} for line in lines]
        return await self.body("setBreakpoints", source={"path": str(file)}, breakpoints=wanted)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "main.osc"
    path.write_text(SCENARIO)
    return path


@asynccontextmanager
async def session() -> AsyncIterator[Editor]:
    """Provide an editor with a session, which has ended after the block."""
    here, there = asyncio.StreamReader(), asyncio.StreamReader()
    editor = Editor(here, there)
    serving = asyncio.create_task(Session(Connection(there, Pipe(here))).serve())
    try:
        yield editor
    finally:
        there.feed_eof()
        async with asyncio.timeout(30):
            await serving


async def test_a_scenario_is_debugged_from_its_start_to_its_end(file: Path) -> None:
    async with session() as editor:
        placed = await editor.launch(file, 10, 99, stopOnEntry=True, seed=1)
        assert [each["verified"] for each in placed["breakpoints"]] == [True, False]
        await editor.body("configurationDone")
        assert (await editor.event("stopped"))["reason"] == "entry"
        await editor.body("continue", threadId=1)
        stopped = await editor.event("stopped")
        assert (stopped["reason"], stopped["description"]) == ("breakpoint", "Paused at a breakpoint, 1.000 s")
        frames = (await editor.body("stackTrace", threadId=stopped["threadId"]))["stackFrames"]
        assert [(frame["line"], frame["column"]) for frame in frames][:2] == [(10, 9), (8, 8)]
        assert frames[0]["source"]["path"] == str(file)
        threads = (await editor.body("threads"))["threads"]
        assert [each["name"].rpartition("/")[2] for each in threads] == ["log[1]", "wait[1]"]
        await editor.body("next", threadId=stopped["threadId"])
        stopped = await editor.event("stopped")
        assert (stopped["reason"], stopped["description"]) == ("step", "Paused after a step, 2.000 s")
        frames = (await editor.body("stackTrace", threadId=stopped["threadId"]))["stackFrames"]
        assert frames[0]["line"] == line_of('log("end")')
        await editor.body("continue", threadId=stopped["threadId"])
        await editor.event("terminated")


async def test_variables_are_shown_with_their_parts(file: Path) -> None:
    async with session() as editor:
        await editor.launch(file, 21)
        await editor.body("configurationDone")
        thread = (await editor.event("stopped"))["threadId"]
        frame = (await editor.body("stackTrace", threadId=thread))["stackFrames"][0]["id"]
        groups = (await editor.body("scopes", frameId=frame))["scopes"]
        assert [each["name"] for each in groups] == ["Scenario main", "Activity"]
        own = groups[0]["variablesReference"]
        where, number = (await editor.body("variables", variablesReference=own))["variables"]
        assert (where["value"], number["value"], number["type"]) == ("point(x: 3)", "1", "int")
        parts = (await editor.body("variables", variablesReference=where["variablesReference"]))["variables"]
        assert [(each["name"], each["value"]) for each in parts] == [("x", "3")]
        found = await editor.body("evaluate", expression="where.x * 2 + count", frameId=frame)
        assert found["result"] == "7"
        refused = await editor.ask("evaluate", expression="bogus", frameId=frame)
        assert (refused["success"], refused["message"]) == (False, "unknown name `bogus`")


async def test_conditions_decide_about_breakpoints(file: Path) -> None:
    async with session() as editor:
        await editor.launch(file)
        conditions = {23: "count == 2", 16: "count > 5", 9: "7"}
        wanted = [{"line": line, "condition": text} for line, text in conditions.items()]
        placed = await editor.body("setBreakpoints", source={"path": str(file)}, breakpoints=wanted)
        assert [each["verified"] for each in placed["breakpoints"]] == [True, True, False]
        assert placed["breakpoints"][2]["message"].startswith("invalid condition: ")
        await editor.body("configurationDone")
        stopped = await editor.event("stopped")
        assert stopped["description"] == "Paused at a breakpoint, 2.000 s"
        await editor.body("seoro/step", to="record")
        assert (await editor.event("stopped"))["reason"] == "step"


async def test_breakpoints_in_reactions_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "main.osc"
    file.write_text(REACTING)
    lines = [
        REACTING.splitlines().index(text) + 1 for text in ("    on @done:", "        emit seen", "    do serial:")
    ]
    async with session() as editor:
        first, second, below = (await editor.launch(file, *lines))["breakpoints"]
        for placed, line in zip((first, second), lines[:2], strict=True):
            assert (placed["verified"], placed["line"]) == (False, line)
            assert placed["message"] == "reactions have no pauses: they are effects of an instant"
        assert below["verified"]
        await editor.body("configurationDone")
        assert (await editor.event("stopped"))["reason"] == "breakpoint"
        await editor.body("continue", threadId=1)
        assert (await editor.event("exited"))["exitCode"] == 0


async def test_logs_and_the_verdict_are_printed(file: Path) -> None:
    async with session() as editor:
        await editor.launch(file, sede=3)
        await editor.body("configurationDone")
        outputs: list[str] = []
        while not any("passed" in text for text in outputs):
            outputs.append((await editor.event("output"))["output"])
        assert outputs[0].strip() == "0.000 s  begin"
        assert outputs[-1] == "passed after 2.000 s\n"
        assert (await editor.event("exited"))["exitCode"] == 0


async def test_a_run_without_debugging_has_no_pauses(file: Path) -> None:
    async with session() as editor:
        await editor.launch(file, 10, stopOnEntry=True, noDebug=True)
        await editor.body("configurationDone")
        assert (await editor.event("exited"))["exitCode"] == 0
        assert not any(each.get("event") == "stopped" for each in editor.seen)


async def test_the_trace_of_a_paused_run_is_in_its_output_folder(file: Path, tmp_path: Path) -> None:
    output = tmp_path / "out"
    output.mkdir()
    (output / "trace.jsonl").write_text("an earlier run\n")
    async with session() as editor:
        await editor.launch(file, line_of("increment(count)"), output="out", cwd=str(tmp_path))
        await editor.body("configurationDone")
        await editor.event("stopped")
        async with asyncio.timeout(30):
            while '"message": "begin"' not in (output / "trace.jsonl").read_text():
                await asyncio.sleep(0.01)
        await editor.body("setBreakpoints", source={"path": str(file)}, breakpoints=[])
        await editor.body("continue", threadId=1)
        assert (await editor.event("exited"))["exitCode"] == 0
    kinds = [json.loads(line)["kind"] for line in (output / "trace.jsonl").read_text().splitlines()]
    assert (kinds[0], kinds[-1]) == ("run.start", "run.end")


async def test_an_output_folder_that_cannot_be_written_ends_the_run(file: Path, tmp_path: Path) -> None:
    (tmp_path / "out").write_text("a file")
    async with session() as editor:
        await editor.launch(file, output=str(tmp_path / "out"))
        await editor.body("configurationDone")
        assert "cannot write" in (await editor.event("output"))["output"]
        assert (await editor.event("exited"))["exitCode"] == 2


async def test_unknown_settings_are_warned_about(file: Path) -> None:
    async with session() as editor:
        await editor.body("initialize")
        await editor.body("launch", program=str(file), sede=3, name="of the editor", __id="1")
        warning = (await editor.event("output"))["output"]
        assert warning == ("unknown setting `sede` of the launch configuration is ignored; did you mean `seed`?\n")


@pytest.mark.parametrize(
    ("command", "arguments", "message"),
    [
        ("launch", {}, "`program` of the launch configuration: Field required"),
        ("launch", {"program": "missing.osc"}, "cannot read"),
        ("continue", {"threadId": 1}, "no scenario; `launch` comes first"),
        ("setBreakpoints", {}, "invalid arguments of `setBreakpoints`"),
        ("fly", {}, "unsupported request `fly`"),
        ("seoro/step", {"to": "moon"}, "cannot step to `moon`; expected `record` or `instant`"),
    ],
)
async def test_invalid_requests_are_refused(command: str, arguments: dict[str, Any], message: str) -> None:
    async with session() as editor:
        answer = await editor.ask(command, **arguments)
        assert not answer["success"]
        assert message in answer["message"]


async def test_a_scenario_with_errors_is_printed_and_refused(tmp_path: Path) -> None:
    file = tmp_path / "wrong.osc"
    file.write_text("scenario main:\n    do serial:\n        fly()\n")
    async with session() as editor:
        answer = await editor.ask("launch", program=str(file))
        assert answer["message"] == "unknown scenario or action `fly`"
        assert "wrong.osc:3:9" in (await editor.event("output"))["output"]


async def test_a_session_that_is_lost_ends_its_run(file: Path) -> None:
    async with session() as editor:
        await editor.launch(file, 10)
        await editor.body("configurationDone")
        await editor.event("stopped")


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"Content-Length: 99999999999\r\n\r\n", "invalid Content-Length"),
        (b"Content-Length: many\r\n\r\n", "invalid Content-Length"),
        (b"Content-Length: 3\r\n\r\n{]}", "not valid JSON"),
        (b"Content-Length: 2\r\n\r\n[]", "not a JSON object"),
        (b"X: " + b"y" * 5000 + b"\r\n", "a header has more than 4096 bytes"),
        (b"X" * 100_000, "a header has more than 4096 bytes"),
    ],
)
async def test_invalid_messages_end_the_connection(data: bytes, message: str) -> None:
    reader = asyncio.StreamReader()
    reader.feed_data(data)
    reader.feed_eof()
    with pytest.raises(InvalidMessage, match=message):
        await Connection(reader, Pipe(asyncio.StreamReader())).receive()


def test_the_command_speaks_on_stdin_and_stdout(file: Path) -> None:
    requests = [
        {"seq": 1, "type": "request", "command": "initialize", "arguments": {}},
        {"seq": 2, "type": "request", "command": "disconnect", "arguments": {}},
    ]
    texts = [json.dumps(each).encode() for each in requests]
    data = b"".join(b"Content-Length: %d\r\n\r\n%s" % (len(text), text) for text in texts)
    command = [sys.executable, "-c", "from seoro.cli.main import main; main(['dap'])"]
    done = subprocess.run(command, input=data, capture_output=True, timeout=60, check=False)
    assert (done.returncode, done.stderr) == (0, b"")
    assert done.stdout.count(b"Content-Length: ") == 2
