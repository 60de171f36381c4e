"""Waiting for what messages of a robot say."""

from __future__ import annotations

from collections.abc import Callable

import anyio


class Signal:
    """Something that changes, and can be waited for; for one event loop."""

    def __init__(self) -> None:
        self._changed = anyio.Event()

    def change(self) -> None:
        """Say that something has changed."""
        self._changed.set()
        self._changed = anyio.Event()

    async def wait_until(self, condition: Callable[[], bool]) -> None:
        """Wait until a condition holds, which is evaluated at once and after each change."""
        while not condition():
            await self._changed.wait()
