"""Condition variable of one event loop, without a lock."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")


class Condition:
    """Notification of changes to waiting tasks of one event loop. Notifying is cheap if no task waits.

    Args:
        on_wait: Called when the first task begins to wait for the next change.
    """

    def __init__(self, on_wait: Callable[[], None] = lambda: None) -> None:
        self._next: asyncio.Event | None = None  # made by the first waiting task
        self._on_wait = on_wait

    @property
    def is_awaited(self) -> bool:
        """Whether a task has begun to wait since the last change."""
        return self._next is not None

    def notify_all(self) -> None:
        """Wake all waiting tasks."""
        if self._next is not None:
            self._next.set()
            self._next = None

    async def wait(self) -> None:
        """Wait for the next change."""
        if self._next is None:
            self._next = asyncio.Event()
            self._on_wait()
        await self._next.wait()

    async def wait_for(self, condition: Callable[[], T], timeout: float | None = None) -> T:
        """Wait until a condition holds; check it now and after each change.

        Args:
            condition: Function whose first true result is returned.
            timeout: Time limit [s] of wall time; None for no limit.

        Raises:
            TimeoutError: The condition did not hold in time.
        """
        async with asyncio.timeout(timeout):
            while not (found := condition()):
                await self.wait()
        return found
