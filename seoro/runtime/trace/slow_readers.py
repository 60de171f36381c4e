"""Waiting for slow readers of a trace."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from typing import Final

import anyio

LOOK_AGAIN: Final = 0.05  # [s]; dropped readers do not notify


async def wait_while(
    is_behind: Callable[[], bool], moved: Callable[[], Awaitable[object]], stop: asyncio.Event
) -> None:
    """Wait while a reader is too far behind, or until a stop.

    Args:
        is_behind: Whether any reader is too far behind.
        moved: Waits until a reader has progressed.
        stop: Ends the wait when set.
    """
    async with anyio.create_task_group() as group:
        group.start_soon(_cancel_when_set, stop, group.cancel_scope)
        while is_behind():
            with anyio.move_on_after(LOOK_AGAIN):
                await moved()
        group.cancel_scope.cancel()


async def _cancel_when_set(event: asyncio.Event, scope: anyio.CancelScope) -> None:
    await event.wait()
    scope.cancel()
