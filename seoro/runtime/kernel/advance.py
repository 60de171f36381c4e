"""`TimeAdvance`: lets time pass between instants, on any clock.

Contract: time passes up to the next due time, or until an external event (`interrupt`). If the clock raises, time
stands still from then on. On deterministic clocks, a run in which nothing is due and no external answer is
expected is stuck, which is reported once.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from functools import partial
from typing import Final

from seoro.runtime.kernel.clock import Clock
from seoro.runtime.kernel.timers import TimerQueue

PATIENCE: Final = 1.0  # [s] of the machine's clock for a step of time after the run has been stopped
SKIPS: Final = 50  # instants in a row before other tasks of the event loop run


class Stuck(RuntimeError):
    """Nothing can happen any more, but the root task has not ended."""

    def __init__(self) -> None:
        super().__init__("nothing can happen any more: no task can go on, no timer is due, and no task is outside")


class TimeAdvance:
    """Lets time pass.

    Args:
        clock: The run's clock.
        timers: Timers of the run.
        stuck: Called when nothing can happen any more.
        clock_failed: Called when the clock raises.
    """

    def __init__(
        self,
        clock: Clock,
        timers: TimerQueue,
        stuck: Callable[[], None],
        clock_failed: Callable[[Exception], None],
    ) -> None:
        self._clock = clock
        self._timers = timers
        self._stuck = stuck
        self._clock_failed = clock_failed
        self._has_been_stuck = False
        self._skips = 0  # instants since other tasks ran
        self._passing: asyncio.Timeout | None = None  # around the current step of time
        self._interrupt = asyncio.Event()
        self.has_failed = False  # whether time stands still
        self.expected = 0  # reports that backends will send as time goes on

    def interrupt(self) -> None:
        """End the current step of time soon: an external event has arrived."""
        self._interrupt.set()

    def clear(self) -> None:
        """Reset the interrupt; the external event is being handled."""
        self._interrupt.clear()

    def begin(self) -> None:
        """Note that other tasks of the event loop have run."""
        self._skips = 0

    def skip(self) -> bool:
        """Advance to the next instant immediately, if the clock can; not forever, since other tasks wait."""
        if self._skips == SKIPS or self.has_failed:
            return False
        due = self._timers.next_due
        if due is None or not self._clock.skip(due):
            return False
        self._skips += 1
        return True

    async def pass_time(self, is_anyone_outside: bool) -> None:
        """Let time pass until the next instant.

        Args:
            is_anyone_outside: Whether a task awaits the outside world.
        """
        due = self._timers.next_due
        is_master = self._clock.deterministic
        if self.has_failed or (is_master and is_anyone_outside):
            await self._interrupt.wait()
        elif is_master and due is None and not self.expected:
            if self._has_been_stuck:  # the run is ending, and awaits a clean-up in real time
                await self._interrupt.wait()
            else:
                self._has_been_stuck = True
                self._stuck()
        else:
            await self._pass_to(due)

    async def _pass_to(self, due: float | None) -> None:
        try:
            async with asyncio.timeout(None) as self._passing:
                await self._clock.pass_time(due, self._interrupt)
        except Exception as error:
            self.has_failed = True
            if self._passing is None or not self._passing.expired():
                self._clock_failed(error)
        finally:
            self._passing = None

    def cut_grace(self) -> None:
        """Limit the current step of time to `PATIENCE`, in case the simulator hangs."""
        if self._passing is not None:
            asyncio.get_running_loop().call_later(PATIENCE, partial(self._give_up, self._passing))

    def _give_up(self, passing: asyncio.Timeout) -> None:
        if passing is self._passing:
            passing.reschedule(asyncio.get_running_loop().time())
