"""Watchdog that stops the robots of holders without heartbeats."""

from __future__ import annotations

from collections.abc import AsyncIterator, Awaitable, Callable

import anyio
from anyio.abc import TaskGroup

from seoro.bridges.leasing.leases import CONNECTION_LOST, Hold, Leases, describe_silence, expire
from seoro.concurrency.condition import Condition

GRACE = 0.01  # [s] for reading heartbeats that have arrived, if this process is slow

Stop = Callable[[Hold, str], Awaitable[None]]
"""Stops the robots of a client for a reason, and ends their goals as interrupted."""


class Watchdog:
    """Stops the robots of lost holders.

    Args:
        leases: Leases of the robots.
        stop: Called when a heartbeat or a token is missing.
        tasks: Tasks that stop robots, so that none waits for another.
    """

    def __init__(self, leases: Leases, stop: Stop, tasks: TaskGroup) -> None:
        self._leases = leases
        self._tasks = tasks
        self._stop = stop
        self._changes = Condition()

    def wake(self) -> None:
        """Recompute the next deadline, after an acquisition or a heartbeat."""
        self._changes.notify_all()

    def lose_connection(self) -> None:
        """Handle the loss of our own connection, after which all tokens are reported anew."""
        self._leases.lose_connection()
        self._changes.notify_all()

    async def watch_deadlines(self) -> None:
        """Stop robots when a heartbeat is overdue; runs as long as the node."""
        leases = self._leases
        while True:
            await self._changes.wait_for(lambda: leases.within() is not None)
            if left := leases.within():
                await anyio.sleep(left)
                continue
            await anyio.sleep(GRACE)
            for hold in leases.overdue():
                self._expire(hold, describe_silence(hold))

    async def watch_tokens(self, tokens: AsyncIterator[tuple[str, bool]]) -> None:
        """Stop robots when the token of their holder disappears, which is at once if its process dies."""
        async for token, is_alive in tokens:
            if (hold := self._leases.token_changed(token, is_alive=is_alive)) is not None:
                self._expire(hold, CONNECTION_LOST)

    def _expire(self, hold: Hold, why: str) -> None:
        hold.is_stopping = True
        self._tasks.start_soon(self._carry_out, hold, expire(hold, why))

    async def _carry_out(self, hold: Hold, reason: str) -> None:
        try:
            await self._stop(hold, reason)
        finally:
            hold.is_stopping = False
