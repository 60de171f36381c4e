"""What is opened or declared for as long as a block lasts."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from functools import partial
from typing import TypeVar

import anyio
import anyio.to_thread

T = TypeVar("T")


@asynccontextmanager
async def declared(make: Callable[[], T], undo: Callable[[T], object]) -> AsyncIterator[T]:
    """Make something in a worker thread, and undo it in one, on every path.

    A task that is cancelled while it waits for the thread does not stop the thread: what that makes all the same
    is undone, too. Neither does a task that is cancelled while it undoes something leave it there.

    Args:
        make: Makes it; what it raises comes out.
        undo: Undoes what was made.
    """
    made = await _carry(make, lambda made: _carry(partial(undo, made)))
    try:
        yield made
    finally:
        await _carry(partial(undo, made))


async def _carry(work: Callable[[], T], undo: Callable[[T], Awaitable[object]] | None = None) -> T:
    """Carry something out in a worker thread, to its end.

    If the task is cancelled meanwhile, from which no scope of anyio's shields, it is afterwards.

    Args:
        work: What is carried out.
        undo: Carried out if the task was cancelled.
    """
    cancelled: asyncio.CancelledError | None = None
    with anyio.CancelScope(shield=True):
        task = asyncio.ensure_future(anyio.to_thread.run_sync(work))
        while not task.done():
            try:
                await asyncio.wait([task])
            except asyncio.CancelledError as error:
                cancelled = error
        if cancelled is not None:
            if undo is not None and task.exception() is None:
                await undo(task.result())
            raise cancelled
    return task.result()
