"""Execution of the combinations of a sweep, each in its own process, several at a time.

A run is `seoro exec` with the values of its combination. Consecutive runs of a worker share a simulator process,
which reloads the world for each run, so that all start from the same state.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field
from pathlib import Path
from typing import Any

import anyio
from anyio.abc import ByteReceiveStream

from seoro.lang.frozen import Value
from seoro.runtime.verdict import RunStatus
from seoro.sweep.processes import kept, simulator_for

MAX_OUTPUT = 10_000_000  # [bytes] of the output of a run
_STATUSES = {status.value: status for status in RunStatus}
SEORO = (sys.executable, "-m", "seoro.cli.main")


class Planned(Value):
    """Planned run of a sweep.

    Args:
        number: Number, from 1.
        values: Values of the axes, by path, in the notation of the language.
        seed: Random seed.
        folder: Folder for its results.
    """

    number: int
    values: Mapping[str, str]
    seed: int
    folder: Path

    @property
    def title(self) -> str:
        """Values of the run, for people."""
        return title_of(self.values)


def title_of(values: Mapping[str, str]) -> str:
    """Describe a combination of values, for people."""
    return " ".join(f"{path}={value}" for path, value in values.items()) or "without variation"


class Ran(Value):
    """Result of a run.

    Args:
        planned: The planned run.
        status: Status of its verdict; an error if it has none.
        reason: Reason of the verdict.
        duration: Duration on the clock of the run [s].
        wall_duration: Duration in wall time [s].
        parameters: Chosen values of parameters, by name.
    """

    planned: Planned
    status: RunStatus
    reason: str = ""
    duration: float = 0.0
    wall_duration: float = 0.0
    parameters: Mapping[str, Any] = field(default_factory=dict)


async def run_all(
    planned: Sequence[Planned],
    arguments: Sequence[str],
    jobs: int,
    stop: anyio.Event,
    on_end: Callable[[Ran], None],
) -> None:
    """Run all planned runs in order; return when all have ended.

    Args:
        planned: Planned runs.
        arguments: Common arguments of `seoro exec`: the file and options.
        jobs: Number of simultaneous runs.
        stop: Once set, active runs are stopped, and no more are started.
        on_end: Called with the result of each started run.
    """
    waiting = iter(planned)

    async def work() -> None:
        """Run until no planned run is left; each worker has its own simulator."""
        is_over = False
        while not is_over:
            async with simulator_for(arguments) as given:
                is_over = not await work_with(given)

    async def work_with(given: Sequence[str]) -> bool:
        """Run with one simulator; return whether to continue with a new one."""
        for each in waiting:
            if stop.is_set():
                return False
            ran = await _run(each, given, stop)
            on_end(ran)
            if ran.status is RunStatus.ERROR:  # maybe of the simulator
                return True
        return False

    async with anyio.create_task_group() as group:
        for _ in range(jobs):
            group.start_soon(work)


async def _run(planned: Planned, arguments: Sequence[str], stop: anyio.Event) -> Ran:
    settings = [f"--set={path}={value}" for path, value in planned.values.items()]
    command = [*SEORO, "exec", *arguments, *settings, f"--seed={planned.seed}", f"-o={planned.folder}", "--json"]
    outputs = [b"", b""]
    async with kept(command) as (process, control), anyio.create_task_group() as group:

        async def read(index: int, stream: ByteReceiveStream | None) -> None:
            assert stream is not None
            async for chunk in stream:
                outputs[index] = (outputs[index] + chunk)[-MAX_OUTPUT:]

        async def end_when_stopped() -> None:
            await stop.wait()
            control.sendall(b"stop\n")

        group.start_soon(end_when_stopped)
        async with anyio.create_task_group() as reading:
            for index, stream in enumerate((process.stdout, process.stderr)):
                reading.start_soon(read, index, stream)
        await process.wait()
        group.cancel_scope.cancel()
    return _ran(planned, *(output.decode(errors="replace") for output in outputs))


def _ran(planned: Planned, stdout: str, stderr: str) -> Ran:
    """Parse the output of a run."""
    try:
        result = json.loads(stdout)
        word = result["status"]
    except (ValueError, KeyError, TypeError):
        lines = [line for line in stderr.strip().splitlines() if not line.startswith("note: ")]
        return Ran(planned, RunStatus.ERROR, lines[0] if lines else "ended without a result")
    return Ran(
        planned,
        _STATUSES.get(word, RunStatus.ERROR),
        result.get("reason", ""),
        result.get("duration", 0.0),
        result.get("wall_duration", 0.0),
        result.get("parameters", {}),
    )
