"""`seoro exec` without `--on`: run a scenario in this process."""

from __future__ import annotations

import argparse
import asyncio
import os
import signal
from collections.abc import Iterator
from contextlib import AbstractAsyncContextManager, contextmanager, nullcontext, suppress
from pathlib import Path

from seoro.cli.event_loop import fast_loop
from seoro.cli.exit_status import Exit
from seoro.cli.files import STDIN, named_source, shown_name
from seoro.cli.report import RunReport
from seoro.cli.results import ResultFiles
from seoro.cli.run_arguments import inputs_of, leasing_of, settings_of, use_file_settings
from seoro.cli.signals import termination_signals
from seoro.cli.video_arguments import video_of
from seoro.embed.plan_cache import load_cached
from seoro.embed.preparation import announcement, prepare
from seoro.embed.runnable import Runnable
from seoro.embed.runs import Run
from seoro.embed.time_limit import WallLimit
from seoro.errors import BackendError
from seoro.runtime.trace.records import write_error_text

_FLUSH_TIME = 2.0  # [s] for pending output when the run is dropped


def run_local(options: argparse.Namespace, files: ResultFiles) -> int:
    """Run the command."""
    try:
        with files.writing_refusals():
            with _terminable():
                scenario = _load(options)
                found = use_file_settings(options, scenario)
                if (
                    found.overrides or found.constraints
                ) and options.file != STDIN:  # a cached plan cannot have other values
                    scenario = _load(options)
                files.check_inputs(inputs_of(options, scenario))
            loop = None if options.ros is None else fast_loop()
            # Files first: an event loop would block Ctrl-C while a pipe waits for its reader.
            with files.open(), asyncio.Runner(loop_factory=loop) as runner:
                return runner.run(_Exec(options, scenario, files, found.limit).main())
    except _Terminated:
        return Exit.CANCELLED


class _Terminated(BaseException):
    """SIGTERM or SIGHUP arrived before the run had anything to clean up."""


@contextmanager
def _terminable() -> Iterator[None]:
    """Raise `_Terminated` on SIGTERM and SIGHUP while the block runs."""

    def terminate(number: int, frame: object) -> None:
        raise _Terminated

    numbers = [number for number in termination_signals() if number != signal.SIGINT]
    before = {number: signal.signal(number, terminate) for number in numbers}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _load(options: argparse.Namespace) -> Runnable:
    path = Path(options.file)
    is_plain = not (options.set or options.constrain) and options.params is None
    if options.file != STDIN and is_plain:
        return load_cached(path, options.scenario)
    from seoro.embed.scenarios import check_file  # noqa: PLC0415 - parser and checks, not needed for cached plans

    path, read = named_source(options.file)
    return check_file(path, read=read).without_errors()


class _Exec:
    """Run of the command."""

    def __init__(
        self, options: argparse.Namespace, scenario: Runnable, files: ResultFiles, limit: WallLimit
    ) -> None:
        self._limit = limit
        self._options = options
        self._scenario = scenario
        self._files = files
        self._video = video_of(options)
        self._run: Run | None = None
        self._clearing: asyncio.Task[None] | None = None
        self._report = RunReport(options, files)

    async def main(self) -> int:
        """Run the scenario, with signal handlers from start to end."""
        loop = asyncio.get_running_loop()
        work = loop.create_task(self._prepare_and_run())
        for number in termination_signals():
            loop.add_signal_handler(number, self._end, number, work)
        try:
            return await work
        except asyncio.CancelledError:
            return self._report.interrupted or Exit.INTERRUPTED
        finally:
            if self._clearing is not None:
                await self._clearing
            with suppress(TimeoutError):
                async with asyncio.timeout(_FLUSH_TIME):
                    await self._report.finish()

    def _end(self, number: signal.Signals, work: asyncio.Task[Exit]) -> None:
        """Stop the run at the first signal; drop it at the second, or at a signal before the run exists."""
        name, is_again = self._report.interrupt(number)
        if self._run is not None and not is_again:
            self._report.progress.print_line(
                f"{name}: stopping robots and cleaning up; press again to stop at once"
            )
            self._run.stop(f"interrupted by {name}")
            return
        if self._run is not None:
            self._run.halt(f"interrupted by {name}")
            from seoro.actions.processes import kill_programs  # noqa: PLC0415 - rarely needed

            kill_programs()
        work.cancel()
        if is_again:  # a clean-up is not cancelled with its task and may hang
            loop = asyncio.get_running_loop()
            loop.call_later(_FLUSH_TIME, os._exit, self._report.interrupted or Exit.INTERRUPTED)
            self._clearing = loop.create_task(self._clear_simulator())

    async def _clear_simulator(self) -> None:
        """Clear a simulator that outlives the run, if the regular clean-up is skipped."""
        if self._run is not None and self._run.simulator is not None:
            with suppress(BackendError):
                await self._run.simulator.clear()

    def _pictures(self, run: Run) -> AbstractAsyncContextManager[None]:
        """Serve live pictures while a block lasts, if there is a simulator."""
        if run.simulator is None or self._options.output_dir is None:
            return nullcontext()
        from seoro.embed.picture_server import serving_pictures  # noqa: PLC0415 - for runs with a simulator and `-o`

        return serving_pictures(run.simulator, self._options.output_dir)

    async def _prepare_and_run(self) -> Exit:
        options, progress = self._options, self._report.progress
        settings = settings_of(
            options,
            leasing=leasing_of(options, lambda reason: progress.print_line(f"waiting: {reason}")),
            observers=(progress, *self._files.traces),
            poses=options.poses if self._files.traces else 0.0,
            scans=(options.scans or 0.0) if self._files.traces else 0.0,
            output_directory=options.output_dir,
            external=options.external,
            replay=options.recorded,
        )
        loop = asyncio.get_running_loop()
        async with prepare(self._scenario, settings) as run:
            if options.dry_run:
                self._report.dry_run(run.seed, run.parameters, run.parameter_texts)
                return Exit.PASSED
            progress.print_line(f"{shown_name(options.file)}: {announcement(run, settings)}\n")
            self._run = run
            progress.set_clock(lambda: run.now)
            self._files.on_failure(lambda error: loop.call_soon_threadsafe(run.abort, write_error_text(error)))
            recorded = nullcontext() if self._video is None else run.recording(*self._video)
            pictures = self._pictures(run)
            async with recorded as recording, pictures, run.running(self._limit):
                verdict = await run.result()
            artifacts = await run.artifacts() if options.output_dir else ()
        files = [(file.path, file.description) for file in run.files]
        if self._video is not None and recording is not None:
            from seoro.embed.video import DESCRIPTION  # noqa: PLC0415 - for runs with a video

            verdict = recording.checked(verdict)
            files.append((self._video[1], DESCRIPTION))
        return await self._report.conclude(verdict, run.parameters, files, _fault_texts(run.fault), artifacts)


def _fault_texts(fault: Exception | None) -> tuple[str, str]:
    """Format the exception of an action in one line and as a traceback; empty without an exception."""
    if fault is None:
        return "", ""
    from traceback import format_exception  # noqa: PLC0415 - for faults only

    from seoro.runtime.explain.reasons import fault_text  # noqa: PLC0415 - the same

    return fault_text(fault), "".join(format_exception(fault))
