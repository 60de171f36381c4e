"""`seoro exec` without `--on`: run a scenario here, in this process."""

from __future__ import annotations

import argparse
import asyncio
import os
import signal
import sys
import traceback
from collections.abc import Iterator, Sequence
from contextlib import AbstractAsyncContextManager, contextmanager, nullcontext, suppress
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import anyio

from seoro.background import background
from seoro.cli.concluding import Conclusion, conclude, progress_of, tell_dry_run
from seoro.cli.exits import OF_STATUS, Exit
from seoro.cli.files import STDIN, STDIN_NAME, read_stdin, shown_name
from seoro.cli.film_arguments import film_of
from seoro.cli.lease_arguments import leasing_of
from seoro.cli.output import error_text
from seoro.cli.results import STDOUT, ResultFiles
from seoro.cli.run_arguments import inputs_of, settings_of, use_file_settings
from seoro.cli.signals import ending_signals
from seoro.embed.runs import Run
from seoro.embed.scenarios import Scenario, check_file, load
from seoro.embed.starting import announcement, prepare
from seoro.embed.walltime import WallLimit
from seoro.errors import BackendError, InvalidScenario, InvalidUse
from seoro.film import DESCRIPTION
from seoro.lang.loader import read_file
from seoro.reasons import fault_text
from seoro.runtime.trace import unwritten
from seoro.runtime.verdict import Verdict

if TYPE_CHECKING:
    from seoro.bridges.wire import Artifact
    from seoro.film import Recording

_LAST_WORDS = 2.0  # [s] for what is still to be written when everything is dropped


def run_local(options: argparse.Namespace) -> int:
    """Run the command."""
    files = ResultFiles(options)
    try:
        with _terminable():
            scenario = _load(options.file)
            limit = use_file_settings(options, scenario).limit
            files.check_inputs(inputs_of(options, scenario))
        with files:  # before there is a loop, which would keep Ctrl-C from one who waits for a pipe to be opened
            return anyio.run(_Exec(options, scenario, files, limit).main, backend_options=_loop_for(options))
    except (InvalidScenario, InvalidUse, BackendError) as error:
        files.write_unrun(shown_name(options.file), error, error_text(error))
        raise
    except _Terminated:
        return Exit.CANCELLED


def _loop_for(options: argparse.Namespace) -> dict[str, Any]:
    """Which event loop a run gets: uvloop, which answers messages sooner, if any may come."""
    return {"use_uvloop": options.ros is not None and find_spec("uvloop") is not None}


class _Terminated(BaseException):
    """SIGTERM or SIGHUP came before there was anything to clean up."""


@contextmanager
def _terminable() -> Iterator[None]:
    """In the block, SIGTERM and SIGHUP are exceptions, as Ctrl-C is."""

    def terminate(number: int, frame: object) -> None:
        raise _Terminated

    numbers = [number for number in ending_signals() if number != signal.SIGINT]
    before = {number: signal.signal(number, terminate) for number in numbers}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _load(file: str) -> Scenario:
    if file != STDIN:
        return load(file)
    path, text = Path(STDIN_NAME), read_stdin()  # what it imports is looked for from the working directory
    return check_file(path, read=lambda other: text if other == path else read_file(other)).without_errors()


class _Exec:
    """One run of the command."""

    def __init__(
        self, options: argparse.Namespace, scenario: Scenario, files: ResultFiles, limit: WallLimit
    ) -> None:
        self._limit = limit
        self._options = options
        self._scenario = scenario
        self._files = files
        self._film = film_of(options)
        self._interrupted: Exit | None = None  # the exit status, when a signal ends the run
        self._run: Run | None = None
        # Where stdout is for a program, people are told on stderr.
        self._progress = progress_of(
            options, sys.stderr if options.json or options.trace == STDOUT else sys.stdout
        )

    async def main(self) -> int:
        """Run, and see to Ctrl-C from the first moment to the last."""
        async with background() as group:
            group.start_soon(self._watch_signals, group.cancel_scope)
            try:
                return await self._prepare_and_run()
            finally:
                with anyio.move_on_after(_LAST_WORDS, shield=True):
                    await self._files.finish()
                    await self._progress.finish()
        return self._interrupted or Exit.INTERRUPTED  # a signal cancelled the group

    async def _watch_signals(self, scope: anyio.CancelScope) -> None:
        """The first signal stops the run in order; the second, or one before there is a run, drops everything."""
        with anyio.open_signal_receiver(*ending_signals()) as signals:
            async for number in signals:
                name = "Ctrl-C" if number == signal.SIGINT else number.name
                second = self._interrupted is not None
                self._interrupted = Exit.INTERRUPTED if number == signal.SIGINT else Exit.CANCELLED
                if self._run is None or second:
                    if self._run is not None:
                        self._run.halt(f"interrupted by {name}")
                        from seoro.actions.processes import kill_programs  # noqa: PLC0415 - has to be there by now

                        kill_programs()
                    scope.cancel()
                    if second:  # a clean-up is not cancelled with its task, and may hang
                        asyncio.get_running_loop().call_later(_LAST_WORDS, os._exit, self._interrupted)
                        await self._clear_simulator()
                    return
                self._progress.say(f"{name}: stopping robots and cleaning up; once more to stop at once")
                self._run.stop(f"interrupted by {name}")

    async def _clear_simulator(self) -> None:
        """Clear a simulator that may live on, when the order in which the run cleans up is not waited for."""
        if self._run is not None and self._run.simulator is not None:
            with anyio.CancelScope(shield=True), suppress(BackendError):
                await self._run.simulator.clear()

    async def _prepare_and_run(self) -> Exit:
        options = self._options
        settings = replace(
            settings_of(options),
            leasing=leasing_of(options, lambda why: self._progress.say(f"waiting: {why}")),
            observers=(self._progress, *self._files.traces),
            output_directory=options.output_dir,
        )
        loop = asyncio.get_running_loop()
        async with prepare(self._scenario, settings) as run:
            if options.dry_run:
                tell_dry_run(options, self._progress, run.seed, run.parameters, run.parameter_texts)
                return Exit.PASSED
            self._progress.say(f"{shown_name(self._options.file)}: {announcement(run, settings)}\n")
            self._run = run
            self._progress.follow(lambda: run.now)
            self._files.when_failed(lambda error: loop.call_soon_threadsafe(run.give_up, unwritten(error)))
            async with self._recording(run) as recording, run.running(self._limit):
                verdict = await run.result()
            artifacts = await run.artifacts() if options.output_dir else ()
        if recording is not None:
            verdict = recording.checked(verdict)
        return await self._conclude(verdict, run, artifacts)

    def _recording(self, run: Run) -> AbstractAsyncContextManager[Recording | None]:
        """Record what is asked for while the block lasts."""
        return nullcontext() if self._film is None else run.recording(*self._film)

    async def _conclude(self, verdict: Verdict, run: Run, artifacts: Sequence[Artifact]) -> Exit:
        files = [(file.path, file.description) for file in run.files]
        if self._film is not None:
            files.append((self._film[1], DESCRIPTION))
        fault = run.fault
        found = Conclusion(
            verdict,
            run.parameters,
            files,
            fault="" if fault is None else fault_text(fault),
            traceback="" if fault is None else "".join(traceback.format_exception(fault)),
            artifacts=artifacts,
        )
        verdict = await conclude(found, self._options, self._files, self._progress)
        return self._interrupted or OF_STATUS[verdict.status]
