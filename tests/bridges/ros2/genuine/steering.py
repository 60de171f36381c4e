"""Genuine nodes that tests steer; see `steered.py`."""

from __future__ import annotations

import itertools
import json
import math
import os
import subprocess
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import anyio
from anyio.abc import Process
from anyio.streams.text import TextReceiveStream

from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.participant import RosNode, connect
from seoro.bridges.ros2.wire import RmwZenoh
from seoro.concurrency.background import background
from tests.bridges.ros2.genuine.conftest import DEADLINE, Ros2, killed_at_end

PROGRAM = Path(__file__).with_name("steered.py")


class SteeredNode:
    """A node in a process. It answers requests, and reports events.

    Args:
        process: Its process.
    """

    def __init__(self, process: Process) -> None:
        self.process = process
        self.output: list[str] = []  # lines that are neither an answer nor an event
        self._numbers = itertools.count()
        self._answers: dict[int, dict[str, Any]] = {}
        self._events: list[dict[str, Any]] = []
        self._changed = anyio.Event()
        self._is_over = False

    async def read(self) -> None:
        """Read answers and events until the process ends."""
        assert self.process.stdout is not None
        rest = ""
        async for text in TextReceiveStream(self.process.stdout, errors="replace"):
            *lines, rest = (rest + text).split("\n")
            for line in lines:
                self._add(line)
        self._is_over = True
        self._notify()

    def _add(self, line: str) -> None:
        try:
            found = json.loads(line)
        except ValueError:
            self.output.append(line)
            return
        if "id" in found:
            self._answers[found["id"]] = found
        else:
            self._events.append(found)
        self._notify()

    def _notify(self) -> None:
        self._changed.set()
        self._changed = anyio.Event()

    async def ask(self, do: str, **arguments: Any) -> Any:
        """Let the node do something, and return its answer."""
        assert self.process.stdin is not None
        number = next(self._numbers)
        await self.process.stdin.send(json.dumps({"id": number, "do": do, **arguments}).encode() + b"\n")
        with anyio.fail_after(DEADLINE):
            while number not in self._answers:
                await self._wait()
        found = self._answers.pop(number)
        assert "error" not in found, found["error"]
        return found["answer"]

    async def event(self, kind: str, **fields: Any) -> dict[str, Any]:
        """Wait for an event with these fields, take it, and return it."""
        wanted = {"event": kind, **fields}
        with anyio.fail_after(DEADLINE):
            while True:
                for index, event in enumerate(self._events):
                    if wanted.items() <= event.items():
                        return self._events.pop(index)
                await self._wait()

    def count(self, kind: str) -> int:
        """Return the number of events that were not taken."""
        return sum(event["event"] == kind for event in self._events)

    async def _wait(self) -> None:
        assert not self._is_over, f"the node ended: {self.output[-20:]}"
        await self._changed.wait()


@asynccontextmanager
async def steered(ros2: Ros2, router: str, name: str = "steered", *arguments: str) -> AsyncIterator[SteeredNode]:
    """Yield a genuine node; its process is killed at the end of the block."""
    command = [str(ros2.folder / "run"), str(PROGRAM), name, *arguments]
    environment = {**os.environ, "ROUTER": router}
    process = await anyio.open_process(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env=environment
    )
    node = SteeredNode(process)
    async with killed_at_end(process), background() as tasks:
        tasks.start_soon(node.read)
        await node.event("ready")
        yield node


@asynccontextmanager
async def own_node(router: str, types: TypeStore | None = None, name: str = "seoro") -> AsyncIterator[RosNode]:
    """Yield a node of seoro in the system of genuine nodes."""
    async with (
        connect(router, types=types or TypeStore.bundled(), dialect=RmwZenoh()) as system,
        system.node(name) as node,
    ):
        yield node


def from_json(value: Any) -> Any:
    """Return a value of JSON with the numbers that JSON lacks."""
    match value:
        case dict():
            return {name: from_json(each) for name, each in value.items()}
        case list():
            return [from_json(each) for each in value]
        case "inf" | "-inf" | "nan":
            return float(value)
        case _:
            return value


def to_json(value: Any) -> Any:
    """Return a value without the numbers that JSON lacks."""
    match value:
        case dict():
            return {name: to_json(each) for name, each in value.items()}
        case list() | tuple():
            return [to_json(each) for each in value]
        case float() if not math.isfinite(value):
            return str(value)
        case _:
            return value
