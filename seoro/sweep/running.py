"""Running the combinations of a sweep: each by a process of its own, some at a time.

A run is `seoro exec` with the values of its combination. Runs that are carried out one after the other share the
process of a simulator, which loads the world anew for each, so that it begins at the same state.
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
from seoro.sweep.keeping import kept
from seoro.sweep.simulators import simulator_for

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
        """Carry out runs as long as there are any, each worker with a simulator of its own."""
        is_over = False
        while not is_over:
            async with simulator_for(arguments) as given:
                is_over = not await work_with(given)

    async def work_with(given: Sequence[str]) -> bool:
        """Carry out runs; returns whether others are left, which are better off with another simulator."""
        for each in waiting:
            if stop.is_set():
                return False
            ran = await _run(each, given, stop)
            told(ran)
            if ran.status is RunStatus.ERROR:  # and maybe the simulator is at fault
                return True
        return False

    async with anyio.create_task_group() as group:
        for _ in range(jobs):
            group.start_soon(work)


async def _run(planned: Planned, arguments: Sequence[str], stop: anyio.Event) -> Ran:
    settings = [f"--set={path}={value}" for path, value in planned.values.items()]
    command = [*SEORO, "exec", *arguments, *settings, f"--seed={planned.seed}", f"-o={planned.folder}", "--json"]
    outputs = {"stdout": b"", "stderr": b""}
    async with kept(command) as (process, control), anyio.create_task_group() as group:

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


def _ran(planned: Planned, stdout: str, stderr: str) -> Ran:
    """What a run said of itself."""
    try:
        result = json.loads(stdout)
        word = result["status"]
    except (ValueError, KeyError, TypeError):
        lines = [line for line in stderr.strip().splitlines() if not line.startswith("note: ")]
        return Ran(planned, RunStatus.ERROR, lines[0] if lines else "it ended without a result")
    return Ran(
        planned,
        _STATUSES.get(word, RunStatus.ERROR),
        result.get("reason", ""),
        result.get("duration", 0.0),
        result.get("wall_duration", 0.0),
        result.get("parameters", {}),
    )
