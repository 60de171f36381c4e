"""Follower of a run on an executor, with the output of a local run."""

from __future__ import annotations

import argparse
import codecs
import signal
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any, cast

import anyio

from seoro.bridges.executor.messages import State
from seoro.bridges.wire.outputs import Artifact
from seoro.cli.exit_status import Exit
from seoro.cli.report import RunReport
from seoro.cli.results import ResultFiles
from seoro.client.runs import RemoteRun
from seoro.concurrency.background import background
from seoro.embed.run_end import Ended, ResultFile
from seoro.embed.video import NAME
from seoro.errors import BackendError, UsageError
from seoro.runtime.verdict import with_write_error
from seoro.text.printable import one_line

QUIET = 1.0  # [s] in the queue of the executor before a note is printed
LONGEST = 100_000  # [characters]; longer lines are split
_FLUSH_TIME = 2.0  # [s]


class LineBuffer:
    """Joins chunks of output, and splits them into lines."""

    def __init__(self) -> None:
        self._decoder = codecs.getincrementaldecoder("utf-8")("replace")
        self._rest = ""

    def add(self, data: bytes) -> None:
        """Add a chunk of output."""
        self._rest += self._decoder.decode(data)

    def pop_lines(self, *, is_end: bool = False) -> list[str]:
        """Remove and return complete lines; at the end, also an incomplete one."""
        *lines, self._rest = self._rest.split("\n")
        if self._rest and (is_end or len(self._rest) > LONGEST):
            lines.append(self._rest)
            self._rest = ""
        return [line.rstrip("\r") for line in lines]


class Follower:
    """Prints the progress of a run, and writes the requested files.

    Args:
        options: Options of the command line, with those of `add_result_arguments`.
        files: Files to write.
        stops: Whether Ctrl-C stops the run; otherwise it ends only this command.
        video: File of the video, if it is not in the output folder.
    """

    def __init__(
        self, options: argparse.Namespace, files: ResultFiles, *, stops: bool, video: Path | None = None
    ) -> None:
        self._options = options
        self._files = files
        self._stops = stops
        self._video = video
        self._now = 0.0
        self._report = RunReport(options, files)
        self._progress = self._report.progress
        self._progress.set_clock(lambda: self._now)

    async def follow(self, run: RemoteRun) -> Exit:
        """Follow a run to its end.

        Raises:
            InvalidScenario, UsageError, BackendError: The run has no verdict.
        """
        run.executor.on_silence = lambda reason: self._note(f"{reason}; the run continues, retrying")
        run.executor.on_answer = lambda: self._note("reconnected")
        async with background() as group:
            group.start_soon(self._watch_signals, run, group.cancel_scope)
            try:
                await self._show(run)
                try:
                    end = await run.end()
                except BackendError:
                    if run.state is not State.CANCELLED:
                        raise
                    print(f"cancelled: {one_line(run.info.reason)}", file=sys.stderr)  # before it started
                    return self._report.interrupted or Exit.CANCELLED
                return await self._conclude(run, end)
            finally:
                with anyio.move_on_after(_FLUSH_TIME, shield=True):
                    await self._report.finish()
        self._note(f"the run continues; `seoro attach {run.id[:8]}` follows it")
        return self._report.interrupted or Exit.INTERRUPTED  # a signal cancelled the group

    async def _show(self, run: RemoteRun) -> None:
        printed = LineBuffer()
        waits = announcement = ""
        async with background() as waiting:
            waiting.start_soon(self._note_queued, run)
            async for info, records in run.parts(printed.add):
                if info.waits and info.waits != waits:
                    self._note(f"run {info.run[:8]} waits: {info.waits}")
                if info.announcement and not announcement:
                    self._progress.print_line(f"{info.file}: {info.announcement}\n")
                waits, announcement = info.waits, announcement or info.announcement
                for line in printed.pop_lines():
                    self._progress.print_output(line)
                for record in records:
                    self._record(record)
        for line in printed.pop_lines(is_end=True):
            self._progress.print_output(line)

    def _record(self, record: dict[str, Any]) -> None:
        self._now = record["t"]
        self._progress.record(record)
        for trace in self._files.traces:
            with suppress(OSError):  # reported by `finish`
                trace.record(record)

    async def _note_queued(self, run: RemoteRun) -> None:
        await anyio.sleep(QUIET)
        if run.state is State.QUEUED and not run.info.waits:
            place = f" (position {run.info.place})" if run.info.place is not None else ""
            self._note(f"run {run.id[:8]} is queued on {run.executor.name}{place}")

    @staticmethod
    def _note(text: str) -> None:
        print(f"note: {one_line(text)}", file=sys.stderr, flush=True)

    async def _watch_signals(self, run: RemoteRun, scope: anyio.CancelScope) -> None:
        """Stop the run at the first signal, if `stops`; end the command at the next."""
        with anyio.open_signal_receiver(signal.SIGINT, signal.SIGTERM) as signals:
            async with anyio.create_task_group() as stopping:
                async for number in signals:
                    name, is_again = self._report.interrupt(number)
                    if is_again or not self._stops:
                        scope.cancel()
                        return
                    self._progress.print_line(
                        f"{name}: stopping robots and cleaning up; press again to exit at once"
                    )
                    stopping.start_soon(run.stop, f"interrupted by {name}")

    async def _conclude(self, run: RemoteRun, end: Ended) -> Exit:
        verdict = end.verdict
        left = [(path, each) for each in end.files if (path := self._local_path(each)) is not None]
        try:
            await self._download(run)
            artifacts = [_artifact(path, each) for path, each in left if each.is_artifact]
        except UsageError as refused:
            verdict, left, artifacts = with_write_error(verdict, str(refused)), [], []
        parameters = cast("dict[str, object]", end.parameters)
        files = [(path, each.description) for path, each in left if not each.is_artifact]
        return await self._report.conclude(verdict, parameters, files, (end.fault, end.traceback), artifacts)

    def _local_path(self, left: ResultFile) -> Path | None:
        """Return the local path of an output file; None if it is not downloaded."""
        if left.path == NAME and self._video is not None:
            return self._video
        folder: Path | None = self._options.output_dir
        return None if folder is None else folder / left.path

    async def _download(self, run: RemoteRun) -> None:
        """Download the output files of the run.

        Raises:
            UsageError: A file cannot be written.
            BackendError: The executor is lost.
        """
        if self._options.output_dir is not None:
            await run.fetch(self._options.output_dir, {} if self._video is None else {NAME: self._video})
        elif self._video is not None:
            await run.fetch_file(NAME, self._video)


def _artifact(path: Path, left: ResultFile) -> Artifact:
    """Convert a downloaded file into an artifact of a local run."""
    return Artifact(name=left.path, media_type="", description=left.description, data=path.read_bytes())
