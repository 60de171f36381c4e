"""Declarations that last as long as a block."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager, suppress
from functools import partial
from typing import TypeVar

import anyio
import anyio.to_thread
import zenoh

T = TypeVar("T")


@asynccontextmanager
async def declared(make: Callable[[], T], undo: Callable[[T], object]) -> AsyncIterator[T]:
    """Call `make` in a worker thread, and `undo` with its result on every path.

    The cancellation of a waiting task does not stop the thread. So the result of a `make` that outlasts its task
    is undone, too, and a cancelled `undo` is completed.

    Args:
        make: Creates the declaration; its exceptions are raised here.
        undo: Ends the declaration.
    """
    made = await _complete(make, lambda made: _complete(partial(undo, made)))
    try:
        yield made
    finally:
        await _complete(partial(undo, made))


async def _complete(work: Callable[[], T], undo: Callable[[T], Awaitable[object]] | None = None) -> T:
    """Call a function in a worker thread, and wait for its end even if this task is cancelled.

    Shields of anyio do not hold off a cancellation by asyncio; it is raised again afterwards.

    Args:
        work: The function.
        undo: Called with the result if the task was cancelled.
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


def undeclare(end: Callable[[], object]) -> None:
    """End a declaration; a closed session has done so already."""
    with suppress(zenoh.ZError):
        end()
