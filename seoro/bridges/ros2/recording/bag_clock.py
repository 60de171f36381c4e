"""The time of a recorded bag, as the clock of a system that a run observes."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Final

from seoro.concurrency.condition import Condition

SECOND: Final = 1_000_000_000  # [ns]
TURNS: Final = 16  # of the event loop, until tasks that follow the bag have reported to their actions


class BagClock:
    """Time of arrival in the bag; see `contracts.ros2.RosClock`. Machine and `/clock` have no time of their own.

    Args:
        start: Time of the first message [ns since the epoch].
        on_wait: Called when a time is waited for.
    """

    jumps = 0

    def __init__(self, start: int, on_wait: Callable[[], None]) -> None:
        self.time = start
        self._on_wait = on_wait
        self._changes = Condition()
        self._moments: list[int] = []
        self._followers = 0

    def now(self) -> float:
        """Return the present time [s since the epoch]."""
        return self.time / SECOND

    def at(self, arrived: float) -> float:
        """Return the time of arrival, which the recorder has noted."""
        return arrived

    def set(self, time: int) -> None:
        """Set the present time [ns since the epoch]."""
        self.time = time
        self._changes.notify_all()

    async def wait_until(self, moment: float) -> None:
        """Wait until a time [s since the epoch]."""
        due = _first_at(moment)
        self._moments.append(due)
        self._on_wait()
        try:
            await self._changes.wait_for(lambda: self.time >= due)
        finally:
            self._moments.remove(due)

    @property
    def next_moment(self) -> int | None:
        """The first time that is waited for [ns since the epoch]; None without one."""
        return min(self._moments, default=None)

    @contextmanager
    def followed(self) -> Iterator[None]:
        """Give tasks that follow the bag their turns, while the block lasts."""
        self._followers += 1
        try:
            yield
        finally:
            self._followers -= 1

    async def settle(self, has_report: Callable[[], bool]) -> None:
        """Let tasks that follow the bag take in the present time, until one has reported to its action."""
        for _ in range(TURNS if self._followers else 0):
            if has_report():
                return
            await asyncio.sleep(0)


def _first_at(moment: float) -> int:
    """Return the first time [ns] that is not before a time [s], which has fewer digits."""
    if moment < 0.0:
        return 0
    time = round(moment * SECOND)
    while time / SECOND < moment:
        time += 1
    return time
