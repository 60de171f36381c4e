"""`DebugClock`: a deterministic clock that stands still while a run is paused."""

from __future__ import annotations

import asyncio
from typing import Protocol

from seoro.runtime.debug.debugger import Debugger
from seoro.runtime.kernel.clock import TIME_DIGITS, Clock

SLICE = 0.1  # [s] of simulated time after which a request to pause is noticed


class PausableClock(Clock, Protocol):
    """A clock that may stand still."""

    def resume(self) -> None:
        """Note that time continues after a pause, which does not count for its rate."""


class DebugClock:
    """Clock of a run with a debugger.

    Args:
        clock: The clock of the run.
        debugger: The debugger.
    """

    deterministic = True

    def __init__(self, clock: PausableClock, debugger: Debugger) -> None:
        self._clock = clock
        self._debugger = debugger
        self.name = clock.name
        self.start = clock.start
        self.now = clock.now
        debugger.on_resume = clock.resume

    def skip(self, due: float) -> bool:
        """Advance immediately, unless a pause was asked for."""
        return not self._debugger.wants_pause and self._clock.skip(due)

    async def pass_time(self, due: float | None, interrupt: asyncio.Event) -> None:
        """Let time pass in slices, after each of which the run may pause."""
        await self._debugger.while_time_passes()
        if interrupt.is_set():
            return
        if self._clock.name != "virtual":
            end = round(self.now() + SLICE, TIME_DIGITS)
            due = end if due is None else min(due, end)
        await self._clock.pass_time(due, interrupt)
