"""Parking of tasks between their steps."""

from __future__ import annotations

import asyncio
from collections.abc import Generator
from types import coroutine
from typing import Any, Final

from seoro.runtime.kernel.task import Task


class _Ready:
    """Awaitable that is done at once."""

    def __await__(self) -> Generator[None, None, None]:
        yield from ()


READY: Final = _Ready()


@coroutine
def parked(task: Task, future: asyncio.Future[Any]) -> Generator[Any, None, Any]:
    """Await the future that resumes a task. A task resumed by its own parking continues without a switch."""
    try:
        return (yield from future)
    except asyncio.CancelledError:
        task.cancel_seen_next = False
        raise
    finally:
        task.parked = None
