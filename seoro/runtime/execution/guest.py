"""The edges of a run: a program around it may cancel it, and its backends end with it.

A cancellation by the program becomes an orderly stop.

Cancel scopes of anyio cancel repeatedly, at every await, which would interrupt clean-ups. A program with such
scopes has imported anyio; other programs need no protection.
"""

from __future__ import annotations

import sys
from collections.abc import AsyncGenerator, Callable, Sequence
from contextlib import asynccontextmanager, suppress

from seoro.errors import BackendError
from seoro.runtime.contracts.backends import Backend


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


async def end_backends(backends: Sequence[Backend], grace: float) -> None:
    """Stop the robots of all backends, the last backend first. Lost backends are skipped.

    Args:
        backends: Backends of the run.
        grace: Time limit for each backend [s].
    """
    import anyio  # noqa: PLC0415 - runs without backends need none of it

    for backend in reversed(backends):
        with anyio.move_on_after(grace), suppress(BackendError):
            await backend.end_run()
