"""Shows a run on an executor as if it were here, to its end."""

from __future__ import annotations

import argparse
import signal
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any, cast

import anyio

from seoro.background import background
from seoro.bridges.executor.messages import RunInfo, State
from seoro.bridges.wire.artifacts import Artifact
from seoro.cli.concluding import Conclusion, conclude, progress_of
from seoro.cli.exits import OF_STATUS, Exit
from seoro.cli.printed import PrintedLines
from seoro.cli.results import STDOUT, ResultFiles
from seoro.client.runs import RemoteRun
from seoro.embed.ends import Ended, LeftFile
from seoro.errors import BackendError, InvalidUse
from seoro.film import NAME
from seoro.runtime.verdict import unproved
from seoro.terminal_text import one_line

QUIET = 1.0  # [s] for which a run may wait for its turn before that is said
_LAST_WORDS = 2.0  # [s]


class Follower:
    """Shows a run, and writes what was asked for.

    Args:
        options: Of the command line, with those of `add_result_arguments`.
        files: What is written.
        stops: Whether Ctrl-C stops the run; else it only ends the command.
        film: Where its film goes, if not to what else it leaves.
    """

    def __init__(
        self, options: argparse.Namespace, files: ResultFiles, *, stops: bool, film: Path | None = None
    ) -> None:
        self._options = options
        self._files = files
        self._stops = stops
        self._film = film
        self._interrupted: Exit | None = None
        self._is_announced = False
        self._waits = ""
        self._now = 0.0
        self._progress = progress_of(
            options, sys.stderr if options.json or options.trace == STDOUT else sys.stdout
        )
        self._progress.follow(lambda: self._now)

    async def follow(self, run: RemoteRun) -> Exit:
        """Follow a run to its end.

        Raises:
            InvalidScenario, InvalidUse, BackendError: It has no verdict.
        """
        run.executor.on_silence = lambda reason: self._note(
            f"{reason}; the run goes on, and so does asking for it"
        )
        run.executor.on_answer = lambda: self._note("the connection is back")
        async with background() as group:
            group.start_soon(self._watch_signals, run, group.cancel_scope)
            try:
                await self._show(run)
                try:
                    end = await run.end()
                except BackendError:
                    if run.state is not State.CANCELLED:
                        raise
                    print(f"cancelled: {one_line(run.info.reason)}", file=sys.stderr)  # before it had begun
                    return self._interrupted or Exit.CANCELLED
                return await self._conclude(run, end)
            finally:
                with anyio.move_on_after(_LAST_WORDS, shield=True):
                    await self._files.finish()
                    await self._progress.finish()
        self._note(f"the run goes on: `seoro attach {run.id[:8]}` shows it")
        return self._interrupted or Exit.INTERRUPTED  # a signal cancelled the group

    async def _show(self, run: RemoteRun) -> None:
        printed = PrintedLines()
        async with background() as waiting:
            waiting.start_soon(self._tell_of_waiting, run)
            async for info, records in run.parts(printed.add):
                self._tell_for_whom_it_waits(info)
                self._announce(info)
                for line in printed.take():
                    self._progress.printed(line)
                for record in records:
                    self._record(record)
        for line in printed.take(is_end=True):
            self._progress.printed(line)

    def _record(self, record: dict[str, Any]) -> None:
        self._now = record["t"]
        self._progress.record(record)
        for trace in self._files.traces:
            with suppress(OSError):  # said when it is finished
                trace.record(record)

    def _tell_for_whom_it_waits(self, info: RunInfo) -> None:
        if info.waits and info.waits != self._waits:
            self._note(f"run {info.run[:8]} waits: {info.waits}")
        self._waits = info.waits

    def _announce(self, info: RunInfo) -> None:
        if info.announcement and not self._is_announced:
            self._is_announced = True
            self._progress.say(f"{info.file}: {info.announcement}\n")

    async def _tell_of_waiting(self, run: RemoteRun) -> None:
        await anyio.sleep(QUIET)
        if run.state is State.QUEUED and not run.info.waits:
            place = f", at place {run.info.place} of those that wait" if run.info.place is not None else ""
            self._note(f"run {run.id[:8]} waits for its turn on {run.executor.name}{place}")

    @staticmethod
    def _note(text: str) -> None:
        print(f"note: {one_line(text)}", file=sys.stderr, flush=True)

    async def _watch_signals(self, run: RemoteRun, scope: anyio.CancelScope) -> None:
        """The first signal stops the run, if that is ours to do, and the next leaves it to itself."""
        with anyio.open_signal_receiver(signal.SIGINT, signal.SIGTERM) as signals:
            async with anyio.create_task_group() as stopping:
                async for number in signals:
                    name = "Ctrl-C" if number == signal.SIGINT else number.name
                    second = self._interrupted is not None
                    self._interrupted = Exit.INTERRUPTED if number == signal.SIGINT else Exit.CANCELLED
                    if second or not self._stops:
                        scope.cancel()
                        return
                    self._progress.say(f"{name}: stopping robots and cleaning up; once more to leave at once")
                    stopping.start_soon(run.stop, f"interrupted by {name}")

    async def _conclude(self, run: RemoteRun, end: Ended) -> Exit:
        verdict = end.verdict
        left = [(path, each) for each in end.files if (path := self._home(each)) is not None]
        try:
            await self._bring(run)
            artifacts = [_artifact(path, each) for path, each in left if each.is_artifact]
        except InvalidUse as refused:
            verdict, left, artifacts = unproved(verdict, str(refused)), [], []
        found = Conclusion(
            verdict,
            cast("dict[str, object]", end.parameters),
            [(path, each.description) for path, each in left if not each.is_artifact],
            end.fault,
            end.traceback,
            artifacts,
        )
        verdict = await conclude(found, self._options, self._files, self._progress)
        return self._interrupted or OF_STATUS[verdict.status]

    def _home(self, left: LeftFile) -> Path | None:
        """Where a file goes that the run has left; None if it stays there."""
        if left.path == NAME and self._film is not None:
            return self._film
        folder: Path | None = self._options.output_dir
        return None if folder is None else folder / left.path

    async def _bring(self, run: RemoteRun) -> None:
        """Bring what the run has left.

        Raises:
            InvalidUse: It cannot be written.
            BackendError: The executor is gone.
        """
        if self._options.output_dir is not None:
            await run.fetch(self._options.output_dir, {} if self._film is None else {NAME: self._film})
        elif self._film is not None:
            await run.fetch_file(NAME, self._film)


def _artifact(path: Path, left: LeftFile) -> Artifact:
    """A file that was fetched, as the simulator gives it to a run here."""
    return Artifact(name=left.path, media_type="", description=left.description, data=path.read_bytes())
