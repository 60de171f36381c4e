"""Holds runs to their limits: of time, of what they use, and of the disk that they share."""

from __future__ import annotations

import asyncio
import shutil
from collections.abc import Callable, Collection
from contextlib import suppress
from pathlib import Path
from typing import Final

from seoro.bridges.executor.messages import State
from seoro.bundle.unpacking import limit_of
from seoro.embed.walltime import WallLimit
from seoro.executor.blobs import in_mebibytes
from seoro.executor.limits import MEBIBYTE, Limits, limit_reached
from seoro.executor.live import LiveRun
from seoro.executor.memory import PERIOD
from seoro.executor.quota import TraceFile, Usage, exceeds
from seoro.executor.room import reserve_of
from seoro.executor.store import RunFolder
from seoro.executor.workers import Worker

SLACK: Final = 30.0  # [s] that a process has to end its run by itself when the wall time is over
KEPT_OF_CULPRIT: Final = MEBIBYTE  # [bytes] of the trace of a run that has filled the disk


async def hold_to_time(live: LiveRun, limits: Limits) -> None:
    """Give a run up that takes too long; how long it waits does not count."""
    limit, reason = _time_limit(limits.time, limit_of(live.submission.manifest.options))
    with suppress(TimeoutError):
        while True:
            await live.changes.wait_for(lambda: live.info.state is State.QUEUED, limit)
            await live.changes.wait_for(lambda: live.info.state is State.RUNNING)
    live.give_up(reason)


def _time_limit(of_policy: float | None, asked: WallLimit) -> tuple[float, str]:
    """Return the time after which the executor ends a run [s], and the reason."""
    if of_policy is not None and of_policy < asked.seconds + SLACK:
        return of_policy, limit_reached(f"the run took longer than {of_policy:g} s", "time")
    return asked.seconds + SLACK, asked.reason


async def hold_to_usage(live: LiveRun, worker: Worker, limits: Limits, folder: RunFolder) -> None:
    """Give a run up that has reached a limit of what it uses, or kill it."""

    def note(usage: Usage) -> None:
        live.output = usage.output + usage.log

    while not (excess := await exceeds(worker.process, limits, folder, note)).is_to_kill:
        live.give_up(excess.reason)
    live.killed = f"it was killed: {excess.reason}"
    worker.kill()


class Reserve:
    """The part of the executor's disk that runs leave free.

    Args:
        folder: On the disk.
        runs: Gives those that may write.
        limits: Gives the limits of a run.
    """

    def __init__(
        self, folder: Path, runs: Callable[[], Collection[LiveRun]], limits: Callable[[LiveRun], Limits]
    ) -> None:
        self._folder = folder
        self._runs = runs
        self._limits = limits
        self._culprits: set[str] = set()

    def of(self, live: LiveRun) -> int:
        """Return the disk space that a run leaves free [bytes]."""
        return reserve_of(self._folder, self._limits(live))

    async def watch(self) -> None:
        """Keep it free; runs as long as the executor."""
        while True:
            await asyncio.sleep(PERIOD)
            if any(live.has_process for live in self._runs()):
                self.keep()

    def keep(self) -> None:
        """If less is free than has to be, give up the run that has written most.

        While that cleans up, no other has to end, unless half of the reserve is gone.
        """
        free = shutil.disk_usage(self._folder).free
        writing = [live for live in self._runs() if live.has_process]
        is_ending = any(live.info.run in self._culprits for live in writing)
        short = [live for live in writing if free < self.of(live) / (2 if is_ending else 1)]
        short = [live for live in short if not live.is_stopped]
        if short:
            culprit = max(short, key=lambda live: live.size + live.output)
            self._culprits.add(culprit.info.run)
            kept = in_mebibytes(self.of(culprit))
            what = f"the executor's disk has {in_mebibytes(free)} left, of which it keeps {kept}"
            advice = "`seoro rm` removes runs, and `free` in the executor's policy is what it keeps"
            culprit.give_up(f"limit reached: {what}, and this run has written most; {advice}")

    def release(self, run: str) -> bool:
        """Forget a run that is over; returns whether it had filled the disk."""
        was_culprit = run in self._culprits
        self._culprits.discard(run)
        return was_culprit


class TraceKeeper:
    """Keeps the trace of a run, which is given up when that reaches a limit.

    Args:
        live: The run.
        file: Its trace.
        limit: Of its size [MiB].
        reserve: Of the disk.
    """

    def __init__(self, live: LiveRun, file: TraceFile, limit: int, reserve: Reserve) -> None:
        self._live = live
        self._file = file
        self._limit = limit
        self._reserve = reserve

    def keep(self, lines: bytes) -> None:
        """Append lines.

        Raises:
            OSError: Something could not be written.
        """
        if self._file.is_full_with(lines):
            self._live.give_up(limit_reached(f"the trace of the run has {self._limit} MiB", "trace"))
        elif self._file.lacks_disk(lines):
            self._reserve.keep()
        if written := self._file.write(lines):
            self._live.grow(written)
