"""Task group for background tasks of a block."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
from anyio.abc import TaskGroup


@asynccontextmanager
async def background() -> AsyncIterator[TaskGroup]:
    """Open a task group whose tasks are cancelled when the block ends.

    Unlike in a plain task group, an exception of the block is not wrapped in an exception group.
    """
    raised: BaseException | None = None
    async with anyio.create_task_group() as group:
        try:
            yield group
        except asyncio.CancelledError:
            raise
        except BaseException as error:
            raised = error
        group.cancel_scope.cancel()
    if raised is not None:
        raise raised
