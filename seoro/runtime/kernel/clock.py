"""Clocks of runs: the protocol `Clock`, and real, virtual and simulated clocks.

Contract: time never goes back. A deterministic clock moves only when the scheduler asks for it.
"""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import Awaitable, Callable
from contextlib import suppress
from typing import Protocol

TIME_DIGITS = 9  # times are kept to the nanosecond, so that 0.1 + 0.2 is due with 0.3
NEXT = 1e-9  # [s] from an instant to the earliest one after it
HORIZON = 1.0  # [s]; longest step when nothing is due, so that an external stop is noticed
PACED_GRANT = 0.05  # [s]; step of a simulation that is slowed to a rate

Settle = Callable[[Callable[[], bool]], Awaitable[None]]


class Clock(Protocol):
    """The time of a run, in seconds since its start. Called by the scheduler only."""

    @property
    def deterministic(self) -> bool:
        """Whether the runtime decides when time moves; it stands still while any task is working."""

    @property
    def name(self) -> str:
        """`real`, `virtual` or `sim`; recorded in the trace."""

    def start(self) -> None:
        """Set time zero. Called once, when the run starts."""

    def now(self) -> float:
        """Return the time [s]; it never goes back. Called when an instant begins."""

    def skip(self, due: float) -> bool:
        """Advance to `due` [s] immediately, if possible. Called when an instant has settled.

        Returns:
            Whether it has advanced; otherwise `pass_time` may be called.
        """

    async def pass_time(self, due: float | None, interrupt: asyncio.Event) -> None:
        """Let time pass until `due`, or until an external event. Called when an instant has settled.

        Args:
            due: Time of the next timer [s]; None without one.
            interrupt: Set when an external event arrives; return soon then.
        """


class TimeServer(Protocol):
    """A simulator whose time advances on request."""

    async def advance(self, until: float) -> float:
        """Simulate until `until` [s since the run's start], or until an earlier event to report.

        All events are reported before the reached time is returned.

        Raises:
            BackendLost: The simulator is lost.
        """


class RealClock:
    """The machine's monotonic clock."""

    name = "real"
    deterministic = False

    def __init__(self) -> None:
        self._start = 0.0

    def start(self) -> None:
        """Set time zero to now."""
        self._start = time.monotonic()

    def now(self) -> float:
        """Return the time since the start [s]."""
        return time.monotonic() - self._start

    def skip(self, due: float) -> bool:
        """Return False: real time has to be awaited."""
        return False

    async def pass_time(self, due: float | None, interrupt: asyncio.Event) -> None:
        """Sleep until due or interrupted; a due timer interrupts too."""
        if due is None:
            await interrupt.wait()
            return
        from seoro.runtime.kernel.alarm import alarm  # noqa: PLC0415 - other clocks do without ctypes, which takes time to load

        with alarm(self._start + due, interrupt.set):
            await interrupt.wait()


class VirtualClock:
    """Time that jumps to the next due time."""

    name = "virtual"
    deterministic = True

    def __init__(self) -> None:
        self._now = 0.0

    def start(self) -> None:
        """Keep the time."""

    def now(self) -> float:
        """Return the time of the last jump [s]."""
        return self._now

    def resume(self) -> None:
        """Keep the time."""

    def skip(self, due: float) -> bool:
        """Jump to `due`."""
        self._now = max(self._now, due)
        return True

    async def pass_time(self, due: float | None, interrupt: asyncio.Event) -> None:
        """Jump to `due`; wait for an interrupt if nothing is due."""
        if due is None:
            await interrupt.wait()
        else:
            # One turn of the event loop, so that other tasks of the program progress during a long run.
            await asyncio.sleep(0)
            self.skip(due)


class SimulatorClock:
    """A simulator's time in lock-step: it advances up to the next due time only.

    Args:
        server: The simulator.
        rate: Simulated seconds per second of the machine's clock; infinite for no limit.
    """

    name = "sim"
    deterministic = True

    def __init__(self, server: TimeServer, rate: float) -> None:
        self._server = server
        self._rate = rate
        self._now = 0.0
        self._wall_start = 0.0

    def start(self) -> None:
        """Set the reference of the rate."""
        self._wall_start = time.monotonic()

    def resume(self) -> None:
        """Note that time continues after a pause, which does not count for the rate."""
        self._wall_start = time.monotonic() - self._now / self._rate

    def now(self) -> float:
        """Return the last reached time [s]."""
        return self._now

    def skip(self, due: float) -> bool:
        """Return False: the simulator has to be asked."""
        return False

    async def pass_time(self, due: float | None, interrupt: asyncio.Event) -> None:
        """Simulate until `due`; return early on an event."""
        horizon = HORIZON if math.isinf(self._rate) else PACED_GRANT
        until = round(self._now + horizon, TIME_DIGITS)
        if due is not None:
            until = min(due, until)
        self._now = await self._server.advance(until)
        behind = self._now / self._rate - (time.monotonic() - self._wall_start)
        if behind > 0:
            with suppress(TimeoutError):
                async with asyncio.timeout(behind):
                    await interrupt.wait()


class FollowedClock(SimulatorClock):
    """Time in lock-step that tasks of a backend follow. They report to the run before time passes again.

    Args:
        server: The simulator or bag.
        rate: See `SimulatorClock`.
        settle: Waits until these tasks have taken in the present time, or a function (one has reported) is true.
    """

    def __init__(self, server: TimeServer, rate: float, settle: Settle) -> None:
        super().__init__(server, rate)
        self._settle = settle

    async def pass_time(self, due: float | None, interrupt: asyncio.Event) -> None:
        """Simulate until `due`, unless a report arrives at the present time."""
        await self._settle(interrupt.is_set)
        if not interrupt.is_set():
            await super().pass_time(due, interrupt)
