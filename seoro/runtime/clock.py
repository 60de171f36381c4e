"""The clocks of runs: the machine's, virtual, and a simulator's."""

from __future__ import annotations

import math
import time

import anyio
import anyio.lowlevel

from seoro.runtime.agenda import TIME_DIGITS
from seoro.runtime.contracts import TimeServer

HORIZON = 1.0  # [s]; longest grant when nothing is due, so that a stop from outside is noticed
PACED_GRANT = 0.05  # [s]; grants of a simulation that is slowed to a rate


class RealClock:
    """The machine's monotonic clock."""

    name = "real"
    deterministic = False

    def __init__(self) -> None:
        self._start = 0.0

    def start(self) -> None:
        """Time zero is now."""
        self._start = time.monotonic()

    def now(self) -> float:
        """Seconds since the start."""
        return time.monotonic() - self._start

    def skip(self, due: float) -> bool:
        """It has to be waited for."""
        return False

    async def pass_time(self, due: float | None, interrupt: anyio.Event) -> None:
        """Sleep until due or interrupted; to be due interrupts, too."""
        if due is None:
            await interrupt.wait()
            return
        from seoro.runtime.alarm import alarm  # noqa: PLC0415 - other clocks do without ctypes, which takes time to load

        with alarm(self._start + due, interrupt.set):
            await interrupt.wait()


class VirtualClock:
    """Time that jumps to what is due next."""

    name = "virtual"
    deterministic = True

    def __init__(self) -> None:
        self._now = 0.0

    def start(self) -> None:
        """Time zero is where it stands."""

    def now(self) -> float:
        """The time it jumped to last."""
        return self._now

    def skip(self, due: float) -> bool:
        """Jump."""
        self._now = max(self._now, due)
        return True

    async def pass_time(self, due: float | None, interrupt: anyio.Event) -> None:
        """Jump; without anything due, wait to be interrupted."""
        if due is None:
            await interrupt.wait()
        else:
            # One turn of the event loop, so that other tasks of the program live on beside a long run.
            await anyio.lowlevel.checkpoint()
            self.skip(due)


class SimulatorClock:
    """A simulator's time in lock-step: it is granted up to what is due next, and never runs on by itself.

    Args:
        server: The simulator.
        rate: Simulated seconds per second of the machine's clock; infinite for as fast as possible.
    """

    name = "sim"
    deterministic = True

    def __init__(self, server: TimeServer, rate: float) -> None:
        self._server = server
        self._rate = rate
        self._now = 0.0
        self._wall_start = 0.0

    def start(self) -> None:
        """The wall time from which a rate is counted."""
        self._wall_start = time.monotonic()

    def now(self) -> float:
        """The time that the simulator reached last."""
        return self._now

    def skip(self, due: float) -> bool:
        """It has to be asked for."""
        return False

    async def pass_time(self, due: float | None, interrupt: anyio.Event) -> None:
        """Grant time up to `due`; return early when something happened."""
        horizon = HORIZON if math.isinf(self._rate) else PACED_GRANT
        until = round(self._now + horizon, TIME_DIGITS)
        if due is not None:
            until = min(due, until)
        self._now = await self._server.advance(until)
        behind = self._now / self._rate - (time.monotonic() - self._wall_start)
        if behind > 0:
            with anyio.move_on_after(behind):
                await interrupt.wait()
