"""Requests of the executor to the process of a run."""

from __future__ import annotations

import asyncio
import os
import threading
import time
from collections.abc import Callable
from typing import IO, Final, TypeAlias

from seoro.executor.process.frames import Frame, read_frame

AFTER_STOP: Final = 20.0  # [s] for the clean-up of robots after a stop
ORPHANED: Final = 15.0  # [s] for the clean-up of a run whose executor has died

EndHandler: TypeAlias = Callable[[Frame, str], object]
"""Called once with `STOP` or `ABORT`, and with each `HALT`, and the reason."""


class Control:
    """Requests of the executor to the run, also before it begins; a thread reads them from the pipe.

    Args:
        pipe: The pipe.
    """

    def __init__(self, pipe: IO[bytes]) -> None:
        self._pipe = pipe
        self._lock = threading.Lock()
        self._ends: list[tuple[Frame, str]] = []  # requests to end the run
        self._on_end: EndHandler = lambda kind, reason: None
        self._go: Callable[[], object] = lambda: None
        self._emissions: list[bytes] = []  # received before the run begins
        self._emit: Callable[[bytes], object] = self._emissions.append
        self._runs: list[bytes] = []  # of a campaign, received before it begins
        self._give: Callable[[bytes], object] = self._runs.append

    def start(self) -> None:
        """Start the thread that reads the pipe."""
        threading.Thread(target=self._listen, name="requests of the executor", daemon=True).start()

    def on_end(self, handler: EndHandler) -> None:
        """Set the handler of requests to end the run, called from another thread; at once for earlier requests."""
        with self._lock:
            self._on_end = handler
            for kind, reason in self._ends:
                handler(kind, reason)

    def on_emission(self, emit: Callable[[bytes], object]) -> None:
        """Set the callback for events to emit, called from another thread; at once for earlier ones."""
        with self._lock:
            self._emit = emit
            for emission in self._emissions:
                emit(emission)

    def on_runs(self, give: Callable[[bytes], object]) -> None:
        """Set the callback for runs of a campaign, called from another thread; at once for earlier ones."""
        with self._lock:
            self._give = give
            for runs in self._runs:
                give(runs)

    def detach(self) -> None:
        """Clear all callbacks, since the event loop of the run is about to end."""
        with self._lock:
            self._give = lambda runs: None
            self._on_end = lambda kind, reason: None
            self._emit = lambda emission: None

    async def acquire_slot(self, request: Callable[[], object]) -> None:
        """Request a run slot, and wait for it."""
        loop, acquired = asyncio.get_running_loop(), asyncio.Event()
        self._go = lambda: loop.call_soon_threadsafe(acquired.set)
        request()
        await acquired.wait()

    def _listen(self) -> None:
        while (frame := read_frame(self._pipe)) is not None:
            if frame[0] is Frame.GO:
                self._go()
            elif frame[0] is Frame.EMIT:
                with self._lock:
                    self._emit(frame[1])
            elif frame[0] is Frame.RUNS:
                with self._lock:
                    self._give(frame[1])
            else:
                self.end(frame[0], frame[1].decode())
        self.end(Frame.HALT, "the executor has died")
        time.sleep(ORPHANED)
        os._exit(1)

    def end(self, kind: Frame, reason: str) -> None:
        """Request the end of the run.

        Args:
            kind: `STOP`, `HALT` or `ABORT`.
            reason: Reason for users.
        """
        with self._lock:
            new = [] if self._ends else [Frame.ABORT if kind is Frame.ABORT else Frame.STOP]
            for each in (*new, Frame.HALT) if kind is Frame.HALT else new:
                self._ends.append((each, reason))
                self._on_end(each, reason)
