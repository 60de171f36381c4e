"""Emergency stop of an executor: stops its runs, and starts none until it is released."""

from __future__ import annotations

import asyncio
import time
from concurrent.futures import Future
from contextlib import suppress
from pathlib import Path
from typing import Final

import anyio.to_thread

from seoro.bridges import wire
from seoro.bridges.leasing.emergency_stop import EmergencyStopState
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused
from seoro.executor.runs.queue import Queue

FILE: Final = "emergency_stop.json"  # in the folder of the executor; it outlasts a restart


class EmergencyStopSwitch:
    """Stops and releases the runs of an executor.

    Args:
        queue: Queue of runs.
        folder: Folder of the executor, for the state of the stop.
    """

    def __init__(self, queue: Queue, folder: Path) -> None:
        self._loop = asyncio.get_running_loop()
        self._queue = queue
        self._emergency = EmergencyStopState(folder / FILE)
        queue.hold_back(self._emergency.reason)

    @property
    def reason(self) -> str:
        """Reason of the emergency stop; empty without a stop."""
        return self._emergency.reason

    def stop(self, request: wire.EmergencyStop) -> Future[wire.StopAcknowledgement]:
        """Stop all active runs; queued runs stay queued. From any thread, even if the event loop is busy.

        Raises:
            RequestRefused: The stop names robots: only their nodes stop them.
        """
        if request.robots:
            raise RequestRefused(Result.NOT_FOUND, "an executor has no robots: send the stop to their nodes")
        began = time.monotonic()
        self._emergency.stop(request)
        runs = self._queue.halt_processes(self._emergency.reason)
        with suppress(RuntimeError):  # the executor ends
            self._loop.call_soon_threadsafe(self._follow)
        stopped: Future[wire.StopAcknowledgement] = Future()
        stopped.set_result(
            wire.StopAcknowledgement(stopped=tuple(run[:8] for run in runs), took=time.monotonic() - began)
        )
        return stopped

    def _follow(self) -> None:
        """Apply the state of the stop in the event loop."""
        self._queue.hold_back(self._emergency.reason)
        if self._emergency.reason:
            self._queue.halt_running(self._emergency.reason)

    def keep(self) -> None:
        """Write the state of the stop to the disk."""
        self._emergency.save()

    async def release(self, request: wire.ReleaseStop) -> None:
        """Release the stop, so that runs start again."""
        await anyio.to_thread.run_sync(self._emergency.release, request)
        self._queue.hold_back("")
