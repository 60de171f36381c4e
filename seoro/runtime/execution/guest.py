"""A run inside another program: cancellation by the program becomes an orderly stop.

Cancel scopes of anyio cancel repeatedly, at every await, which would interrupt clean-ups. A program with such
scopes has imported anyio; other programs need no protection.
"""

from __future__ import annotations

import sys
from collections.abc import AsyncGenerator, Callable
from contextlib import asynccontextmanager


@asynccontextmanager
async def shielded(stop: Callable[[], None]) -> AsyncGenerator[None]:
    """Call `stop` when an anyio scope around the block is cancelled, without interrupting the block.

    Leaving the block raises if such a scope or this task was cancelled.

    Args:
        stop: Called immediately.
    """
    if "anyio" not in sys.modules:
        yield
        return
    import anyio  # noqa: PLC0415 - loaded by the program already

    async def call_when_cancelled() -> None:
        try:
            await anyio.sleep_forever()
        finally:
            stop()

    async with anyio.create_task_group() as watch:
        watch.start_soon(call_when_cancelled)
        with anyio.CancelScope(shield=True):
            yield
        watch.cancel_scope.cancel()
