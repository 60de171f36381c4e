"""The emergency stop of an executor: its runs are stopped, and none begins until it is released."""

from __future__ import annotations

import time
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Final

import anyio.to_thread

from seoro.bridges import wire
from seoro.bridges.leasing.latch import Latch
from seoro.executor.queue import Queue

FILE: Final = "emergency_stop.json"  # in the folder of the executor; it outlasts a restart


class Emergency:
    """Whether runs may go on.

    Args:
        queue: The runs.
        folder: Of the executor.
    """

    def __init__(self, queue: Queue, folder: Path) -> None:
        self._queue = queue
        self._latch = Latch(folder / FILE)
        queue.hold_back(self._latch.reason)

    @property
    def reason(self) -> str:
        """Why no run begins; empty if nothing speaks against it."""
        return self._latch.reason

    async def stop(self, asked: wire.EmergencyStop) -> wire.EmergencyStopped:
        """Stop all runs; those that wait go on waiting."""
        began = time.monotonic()
        self._latch.stop(asked)
        self._queue.hold_back(self._latch.reason)
        stopped = self._queue.halt_running(self._latch.reason)
        await anyio.to_thread.run_sync(self._latch.sync)
        return wire.EmergencyStopped(stopped=tuple(run[:8] for run in stopped), took=time.monotonic() - began)

    async def release(self, asked: wire.ReleaseStop) -> wire.Empty:
        """Let runs begin again."""
        self._latch.release(asked)
        self._queue.hold_back("")
        return wire.Empty()

    async def obey(self, heard: AsyncIterator[wire.EmergencyStop]) -> None:
        """Stop when it is published; runs as long as the executor."""
        async for asked in heard:
            await self.stop(asked)
