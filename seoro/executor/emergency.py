"""The emergency stop of an executor: its runs are stopped, and none begins until it is released."""

from __future__ import annotations

import asyncio
import time
from concurrent.futures import Future
from contextlib import suppress
from pathlib import Path
from typing import Final

import anyio.to_thread

from seoro.bridges import wire
from seoro.bridges.leasing.latch import Latch
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused
from seoro.executor.queue import Queue

FILE: Final = "emergency_stop.json"  # in the folder of the executor; it outlasts a restart


class Emergency:
    """Whether runs may go on.

    Args:
        queue: The runs.
        folder: Of the executor.
    """

    def __init__(self, queue: Queue, folder: Path) -> None:
        self._loop = asyncio.get_running_loop()
        self._queue = queue
        self._latch = Latch(folder / FILE)
        queue.hold_back(self._latch.reason)

    @property
    def reason(self) -> str:
        """Why no run begins; empty if nothing speaks against it."""
        return self._latch.reason

    def stop(self, asked: wire.EmergencyStop) -> Future[wire.EmergencyStopped]:
        """Stop all runs; those that wait go on waiting. From any thread, whatever the event loop does.

        Raises:
            RequestRefused: Robots are named: their nodes stop them, and end the runs that have them.
        """
        if asked.robots:
            raise RequestRefused(Result.NOT_FOUND, "an executor has no robots: stop them at their nodes")
        began = time.monotonic()
        self._latch.stop(asked)
        runs = self._queue.halt_processes(self._latch.reason)
        with suppress(RuntimeError):  # the executor ends
            self._loop.call_soon_threadsafe(self._follow)
        stopped: Future[wire.EmergencyStopped] = Future()
        stopped.set_result(
            wire.EmergencyStopped(stopped=tuple(run[:8] for run in runs), took=time.monotonic() - began)
        )
        return stopped

    def _follow(self) -> None:
        """Note in the event loop what holds."""
        self._queue.hold_back(self._latch.reason)
        if self._latch.reason:
            self._queue.halt_running(self._latch.reason)

    def keep(self) -> None:
        """Write down whether runs may begin."""
        self._latch.keep()

    async def release(self, asked: wire.ReleaseStop) -> wire.Empty:
        """Let runs begin again."""
        await anyio.to_thread.run_sync(self._latch.release, asked)
        self._queue.hold_back("")
        return wire.Empty()
