"""What is opened or declared for as long as a block lasts."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import TypeVar

import anyio
import anyio.to_thread

T = TypeVar("T")


@asynccontextmanager
async def declared(make: Callable[[], T], undo: Callable[[T], object]) -> AsyncIterator[T]:
    """Make something in a worker thread, and undo it in one, on every path.

    A task that is cancelled while it waits for the thread does not stop the thread: what that makes all the same
    is undone, too.

    Args:
        make: Makes it; what it raises comes out.
        undo: Undoes what was made.
    """
    making = asyncio.ensure_future(anyio.to_thread.run_sync(make))
    try:
        made = await asyncio.shield(making)
    except asyncio.CancelledError:
        with anyio.CancelScope(shield=True):
            await asyncio.wait([making])
            if making.exception() is None:
                await anyio.to_thread.run_sync(undo, making.result())
        raise
    try:
        yield made
    finally:
        with anyio.CancelScope(shield=True):
            await anyio.to_thread.run_sync(undo, made)
