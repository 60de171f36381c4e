"""What happens when those who hold robots of a node give no sign of life."""

from __future__ import annotations

from collections.abc import AsyncIterator, Awaitable, Callable

import anyio
from anyio.abc import TaskGroup

from seoro.bridges.leasing.leases import GONE, Hold, Leases, lapse, silence
from seoro.changes import Changes

ARRIVED = 0.01  # [s] for a sign of life that has arrived to be read, where it is this process that is slow

Stop = Callable[[Hold, str], Awaitable[None]]
"""Stops the robots of a client for a reason, and ends their goals as interrupted."""


class Watchdog:
    """Stops the robots of clients that are gone.

    Args:
        leases: Who has which robots.
        stop: Called when a client gives no sign of life any more.
        tasks: Where that runs, so that no robot waits for another to be stopped.
    """

    def __init__(self, leases: Leases, stop: Stop, tasks: TaskGroup) -> None:
        self._leases = leases
        self._tasks = tasks
        self._stop = stop
        self._changes = Changes()

    def note(self) -> None:
        """Somebody has taken robots, or is back."""
        self._changes.tell()

    def lose_sight(self) -> None:
        """The connection to all tokens is gone, on this side, and comes back."""
        self._leases.lose_sight()
        self._changes.tell()

    async def watch_deadlines(self) -> None:
        """Stop robots when a sign of life is overdue; runs as long as the node."""
        leases = self._leases
        while True:
            await self._changes.wait_for(lambda: leases.within() is not None)
            if left := leases.within():
                await anyio.sleep(left)
                continue
            await anyio.sleep(ARRIVED)
            for hold in leases.overdue():
                self._lapse(hold, silence(hold))

    async def watch_tokens(self, tokens: AsyncIterator[tuple[str, bool]]) -> None:
        """Stop robots when the token of who holds them is gone, which is as soon as its process has died."""
        async for token, is_alive in tokens:
            if (hold := self._leases.token_changed(token, is_alive=is_alive)) is not None:
                self._lapse(hold, GONE)

    def _lapse(self, hold: Hold, why: str) -> None:
        hold.is_stopping = True
        self._tasks.start_soon(self._carry_out, hold, lapse(hold, why))

    async def _carry_out(self, hold: Hold, reason: str) -> None:
        try:
            await self._stop(hold, reason)
        finally:
            hold.is_stopping = False
