"""Running the combinations of a sweep: each by a process of its own, some at a time.

A run is `seoro exec` with the values of its combination, under the keeper that programs of scenarios have
(`actions/keeper.py`): nothing of it is left when the sweep ends, or dies.
"""

from __future__ import annotations

import json
import signal
import socket
import subprocess
import sys
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from contextlib import ExitStack, asynccontextmanager
from dataclasses import field
from pathlib import Path
from typing import Any

import anyio
from anyio.abc import ByteReceiveStream, Process

from seoro.actions.processes import KEEPER
from seoro.lang.frozen import Value
from seoro.runtime.verdict import RunStatus

ENDING_TIME = 15.0  # [s] that a run has for its clean-up when the sweep is ended
MAX_OUTPUT = 10_000_000  # [bytes] of what a run says that are read
_STATUSES = {status.value: status for status in RunStatus}
SEORO = (sys.executable, "-m", "seoro.cli.main")


class Planned(Value):
    """A run of a sweep.

    Args:
        number: From 1.
        values: Of the axes, by path, as the language writes them.
        seed: Of all that is drawn.
        folder: For its results.
    """

    number: int
    values: Mapping[str, str]
    seed: int
    folder: Path

    @property
    def title(self) -> str:
        """What it varies, for people."""
        return " ".join(f"{path}={value}" for path, value in self.values.items()) or "as it is"


class Ran(Value):
    """What became of a run.

    Args:
        planned: The run.
        status: Its verdict; an error if there is none.
        reason: Why.
        duration: On the run's clock [s].
        wall_duration: On the machine's clock [s].
        parameters: All chosen values of the scenario's parameters, by name.
    """

    planned: Planned
    status: RunStatus
    reason: str = ""
    duration: float = 0.0
    wall_duration: float = 0.0
    parameters: Mapping[str, Any] = field(default_factory=dict)


async def run_all(
    planned: Sequence[Planned], arguments: Sequence[str], jobs: int, stop: anyio.Event, told: Callable[[Ran], None]
) -> None:
    """Run them, in their order, and return when all have ended.

    Args:
        planned: The runs.
        arguments: Of `seoro exec`, for all of them: the file, and options.
        jobs: How many run at a time.
        stop: Once set, what runs is stopped, and nothing more is started.
        told: Called with the end of each that was started.
    """
    waiting = iter(planned)

    async def work() -> None:
        for each in waiting:
            if stop.is_set():
                return
            told(await _run(each, arguments, stop))

    async with anyio.create_task_group() as group:
        for _ in range(jobs):
            group.start_soon(work)


async def _run(planned: Planned, arguments: Sequence[str], stop: anyio.Event) -> Ran:
    settings = [f"--set={path}={value}" for path, value in planned.values.items()]
    command = [*SEORO, "exec", *arguments, *settings, f"--seed={planned.seed}", f"-o={planned.folder}", "--json"]
    outputs = {"stdout": b"", "stderr": b""}
    async with _kept(command) as (process, control), anyio.create_task_group() as group:

        async def read(name: str, stream: ByteReceiveStream | None) -> None:
            assert stream is not None
            async for chunk in stream:
                outputs[name] = (outputs[name] + chunk)[-MAX_OUTPUT:]

        async def end_when_stopped() -> None:
            await stop.wait()
            control.sendall(b"stop\n")

        group.start_soon(end_when_stopped)
        async with anyio.create_task_group() as reading:
            reading.start_soon(read, "stdout", process.stdout)
            reading.start_soon(read, "stderr", process.stderr)
        await process.wait()
        group.cancel_scope.cancel()
    return _ran(planned, outputs["stdout"].decode(errors="replace"), outputs["stderr"].decode(errors="replace"))


@asynccontextmanager
async def _kept(command: Sequence[str]) -> AsyncIterator[tuple[Process, socket.socket]]:
    """A process under a keeper, and the socket by which that is told to end it; it has ended after the block."""
    ours, theirs = socket.socketpair()
    with ExitStack() as stack:
        stack.enter_context(ours)
        with theirs:
            keeper = [sys.executable, "-I", "-S", str(KEEPER), str(int(signal.SIGINT)), str(ENDING_TIME)]
            process = await anyio.open_process(
                [*keeper, *command],
                stdin=theirs.fileno(),
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                start_new_session=True,
            )
        try:
            yield process, ours
        finally:
            stack.close()  # then the keeper ends what is left
            with anyio.CancelScope(shield=True):
                await process.aclose()


def _ran(planned: Planned, stdout: str, stderr: str) -> Ran:
    """What a run said of itself."""
    try:
        result = json.loads(stdout)
        word = result["status"]
    except (ValueError, KeyError, TypeError):
        lines = stderr.strip().splitlines()
        return Ran(planned, RunStatus.ERROR, lines[0] if lines else "it ended without a result")
    return Ran(
        planned,
        _STATUSES.get(word, RunStatus.ERROR),
        result.get("reason", ""),
        result.get("duration", 0.0),
        result.get("wall_duration", 0.0),
        result.get("parameters", {}),
    )
