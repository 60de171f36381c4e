"""The tool that runs a scenario, in a process of its own with an output folder of its own."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from datetime import UTC, datetime
from itertools import count
from pathlib import Path
from shutil import rmtree
from tempfile import TemporaryFile
from typing import IO, Final

import anyio
import anyio.to_thread
from anyio.abc import Process
from pydantic import Field

from seoro.embed.file_settings import with_file_settings
from seoro.embed.options import Options, Simulator
from seoro.errors import UsageError
from seoro.files.inputs import resolved
from seoro.mcp.bounds import LONGEST_TEXT
from seoro.mcp.reading import checked_scenario
from seoro.mcp.results import ExplainRun, ResultReader, RunResult
from seoro.mcp.served_folder import ServedFolder
from seoro.mcp.tool import Answer, Arguments
from seoro.runtime.execution.outputs import TRACE
from seoro.text.printable import printable

FOLDER: Final = "runs"  # below the served folder
LIMIT: Final = 300.0  # [s] of wall time, unless the request gives one
LONGEST: Final = 3600.0  # [s] of wall time
STOP: Final = 20.0  # [s] for a cancelled run to stop robots and clean up
_START: Final = 60.0  # [s] beyond the limit, for imports and the simulator


class RunScenario(Arguments):
    """Arguments of `run_scenario`."""

    file: str = Field(description="scenario file, relative to the served folder")
    scenario: str = Field("", description="name of the scenario; may be left out if the file has one")
    parameters: dict[str, str] = Field(
        {}, description="values of parameters: path to expression, such as goal.x: 3m"
    )
    simulator: str = Field("", description="mujoco or pybullet; empty for that of the file or the project")
    seed: int | None = Field(None, ge=0, description="random seed; null for that of the file, else a random one")
    timeout: float = Field(LIMIT, gt=0.0, le=LONGEST, description="limit of the wall time [s]")


class RunOutcome(Answer):
    """Outcome of a run."""

    exit_status: int = Field(description="0 passed, 1 failed, 3 error without a verdict, 4 cancelled")
    output: str = Field(description="last characters of what the run printed")
    result: RunResult


class Runner:
    """Runs scenarios, one at a time.

    Args:
        served: Folder of the server.
        results: Reader of results.
    """

    def __init__(self, served: ServedFolder, results: ResultReader) -> None:
        self._served = served
        self._results = results
        self._slot = anyio.Lock()

    async def run_scenario(self, given: RunScenario) -> RunOutcome:
        """Run a scenario; a cancelled request ends the run.

        Raises:
            UsageError: The scenario is invalid, did not start, or would use the robots of a lab.
        """
        async with self._slot:
            options = await anyio.to_thread.run_sync(self._options, given)
            folder = await anyio.to_thread.run_sync(self._new_folder, Path(given.file).stem)
            try:
                status, text = await self._carry_out([*options, f"--output-dir={folder}"], given.timeout)
            finally:
                has_begun = (folder / TRACE).is_file()
                if not has_begun:
                    rmtree(folder, ignore_errors=True)
            if not has_begun:
                raise UsageError(f"the run did not start:\n{text}", help="`check_scenarios` checks the file")
            name = folder.relative_to(self._served.root).as_posix()
            result = await anyio.to_thread.run_sync(self._results.explain_run, ExplainRun(run=name))
            return RunOutcome(exit_status=status, output=text, result=result)

    async def _carry_out(self, command: list[str], limit: float) -> tuple[int, str]:
        """Carry out a run; return its exit status, and the end of its output."""
        with TemporaryFile() as output:
            async with _running(command, self._served.root, output) as process:
                with anyio.move_on_after(limit + _START):
                    await process.wait()
            assert process.returncode is not None
            return process.returncode, _tail(output)

    def _options(self, given: RunScenario) -> list[str]:
        """Return the command; robots of a lab are refused, since the agent was not allowed to use them."""
        path = self._served.scenario(given.file)
        scenario = checked_scenario(path, given.file)
        asked = Options(
            name=given.scenario or None,
            simulator=Simulator(given.simulator) if given.simulator else None,
            timeout=given.timeout,
        )
        settings, found = with_file_settings(scenario, asked, "timeout")
        if found.lab is not None:
            raise UsageError("the project names a lab, whose robots may be real", help="name a `simulator`")
        texts = {
            "scenario": given.scenario,
            "sim": given.simulator,
            "seed": "" if given.seed is None else str(given.seed),
            "timeout": str(given.timeout),
            "rate": "" if settings.simulator is None else "max",
        }
        named = [f"--{name}={text}" for name, text in texts.items() if text]
        values = [f"--set={parameter}={value}" for parameter, value in given.parameters.items()]
        return [sys.executable, "-m", "seoro", "exec", str(path), "--local", "--die-with-parent", *named, *values]

    def _new_folder(self, stem: str) -> Path:
        """Create a folder for the results."""
        base = self._served.root / FOLDER
        if not resolved(base).is_relative_to(self._served.root):
            raise UsageError(f"`{FOLDER}` leads out of the served folder", help="remove the link")
        start = f"{datetime.now(UTC):%Y%m%d-%H%M%S}-{stem}"
        for number in count(1):
            folder = base / (start if number == 1 else f"{start}-{number}")
            with suppress(FileExistsError):
                folder.mkdir(parents=True)
                break
        return folder


@asynccontextmanager
async def _running(command: list[str], folder: Path, output: IO[bytes]) -> AsyncIterator[Process]:
    """Run a process in its own session; it has ended after the block."""
    process = await anyio.open_process(
        command, stdin=subprocess.PIPE, stdout=output, stderr=output, cwd=folder, start_new_session=True
    )
    try:
        yield process
    finally:
        with anyio.CancelScope(shield=True):
            await _stop(process)


async def _stop(process: Process) -> None:
    """Interrupt a process, or kill it and its group if it does not end."""
    if process.returncode is None:
        with suppress(ProcessLookupError):
            process.send_signal(signal.SIGINT)
        with anyio.move_on_after(STOP):
            await process.wait()
    if process.returncode is None:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        await process.wait()
    await process.aclose()


def _tail(output: IO[bytes]) -> str:
    size = output.seek(0, os.SEEK_END)
    output.seek(max(0, size - LONGEST_TEXT))
    return printable(output.read().decode("utf-8", "replace")).strip()
