"""Tasks that accompany a block of code."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
from anyio.abc import TaskGroup


@asynccontextmanager
async def background() -> AsyncIterator[TaskGroup]:
    """A task group whose tasks are cancelled when the block ends.

    An exception of the block comes out as it is, not wrapped in a group as a plain task group would have it: the
    tasks only accompany what the block is about.
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
