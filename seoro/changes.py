"""Waiting for what changes: look, wait for the next change, look again."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import anyio

T = TypeVar("T")


class Changes:
    """The changes of something, for those who wait for them; for one event loop.

    Telling of a change costs next to nothing while nobody waits.
    """

    def __init__(self) -> None:
        self._next: anyio.Event | None = None  # made for those who wait

    def tell(self) -> None:
        """Say that something has changed."""
        if self._next is not None:
            self._next.set()
            self._next = None

    async def wait(self) -> None:
        """Wait for the next change."""
        if self._next is None:
            self._next = anyio.Event()
        await self._next.wait()

    async def wait_for(self, condition: Callable[[], T], timeout: float | None = None) -> T:
        """Wait until a condition holds, looking at it at once and after each change.

        Args:
            condition: Gives something true, which is returned, once it holds.
            timeout: [s] of the machine's clock; without end when None.

        Raises:
            TimeoutError: It did not hold in time.
        """
        with anyio.fail_after(timeout):
            while not (found := condition()):
                await self.wait()
        return found
