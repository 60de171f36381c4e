"""Enforcement of limits: time and resources of runs, and free space of the shared disk."""

from __future__ import annotations

import asyncio
import shutil
from collections.abc import Callable, Collection
from contextlib import suppress
from pathlib import Path
from typing import Final

from seoro.bridges.executor.messages import State
from seoro.bundle.unpack import limit_of
from seoro.embed.time_limit import WallLimit
from seoro.executor.limits import MEBIBYTE, Limits, limit_reached
from seoro.executor.process.pool import Worker
from seoro.executor.runs.active_run import ActiveRun
from seoro.executor.runs.memory import PERIOD
from seoro.executor.runs.usage import TraceFile, Usage, exceeds
from seoro.executor.storage.blobs import in_mebibytes, reserve_of
from seoro.executor.storage.run_folder import RunFolder

SLACK: Final = 30.0  # [s] for a process to end its run by itself after its time limit
KEPT_OF_CULPRIT: Final = MEBIBYTE  # [bytes] of the trace of a run that has filled the disk


async def hold_to_time(live: ActiveRun, limits: Limits) -> None:
    """End a run as an error after its time limit; waiting time does not count.

    A worker of a campaign limits the time of each run itself. It is asked to give way before its own limit.
    """
    if live.submission.campaign is not None:
        assert limits.time is not None, "set by the default limits"
        limit, reason = limits.time / 2.0, _too_long(limits.time)
        await asyncio.sleep(limit)
        live.set(is_wanted=True)
    else:
        limit, reason = _time_limit(limits.time, limit_of(live.submission.manifest.options))
    with suppress(TimeoutError):
        while True:
            await live.changes.wait_for(lambda: live.info.state is State.QUEUED, limit)
            await live.changes.wait_for(lambda: live.info.state is State.RUNNING)
    live.abort(reason)


def _time_limit(of_policy: float | None, asked: WallLimit) -> tuple[float, str]:
    """Return the time after which the executor ends a run [s], and the reason."""
    if of_policy is not None and of_policy < asked.seconds + SLACK:
        return of_policy, _too_long(of_policy)
    return asked.seconds + SLACK, asked.reason


def _too_long(limit: float) -> str:
    return limit_reached(f"the run took longer than {limit:g} s", "time")


async def hold_to_usage(live: ActiveRun, worker: Worker, limits: Limits, folder: RunFolder) -> None:
    """End a run as an error when it exceeds a limit of resources, or kill it."""

    def note(usage: Usage) -> None:
        live.output = usage.output + usage.log

    while not (excess := await exceeds(worker.process, limits, folder, note)).is_to_kill:
        live.abort(excess.reason)
    live.killed = f"the run was killed: {excess.reason}"
    worker.kill()


class Reserve:
    """Free space of the executor's disk.

    Args:
        folder: Folder on the disk.
        runs: Returns the active runs.
        limits: Returns the limits of a run.
    """

    def __init__(
        self, folder: Path, runs: Callable[[], Collection[ActiveRun]], limits: Callable[[ActiveRun], Limits]
    ) -> None:
        self._folder = folder
        self._runs = runs
        self._limits = limits
        self._culprits: set[str] = set()

    def of(self, live: ActiveRun) -> int:
        """Return the disk space that a run leaves free [bytes]."""
        return reserve_of(self._folder, self._limits(live))

    async def watch(self) -> None:
        """Check the free space periodically, as long as the executor runs."""
        while True:
            await asyncio.sleep(PERIOD)
            if any(live.has_process for live in self._runs()):
                self.keep()

    def keep(self) -> None:
        """If the disk has too little free space, end the run that has written most as an error.

        While it cleans up, other runs continue, unless half of the reserve is used.
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
            what = f"the executor's disk has {in_mebibytes(free)} left; {kept} have to stay free"
            advice = "remove old runs by `seoro rm`, or change `free` in the executor's policy"
            culprit.abort(f"limit reached: {what}, and this run has written most; {advice}")

    def release(self, run: str) -> bool:
        """Remove a finished run; returns whether it had filled the disk."""
        was_culprit = run in self._culprits
        self._culprits.discard(run)
        return was_culprit


def append_trace(live: ActiveRun, file: TraceFile, reserve: Reserve, lines: bytes) -> None:
    """Append lines to the trace of a run, which is aborted when the trace reaches its limit.

    Raises:
        OSError: Writing failed.
    """
    if file.is_full_with(lines):
        live.abort(limit_reached(f"the trace of the run has {file.limit // MEBIBYTE} MiB", "trace"))
    elif file.lacks_disk(lines):
        reserve.keep()
    if written := file.write(lines):
        live.grow(written)
