"""Concurrent calls with results."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterable
from typing import TypeVar

import anyio

T = TypeVar("T")
R = TypeVar("R")


async def gather(work: Callable[[T], Awaitable[R]], items: Iterable[T]) -> list[R]:
    """Call an async function with each item concurrently; returns the results in the order of the items."""
    results: dict[int, R] = {}

    async def collect(index: int, item: T) -> None:
        results[index] = await work(item)

    async with anyio.create_task_group() as tasks:
        for index, item in enumerate(items):
            tasks.start_soon(collect, index, item)
    return [results[index] for index in sorted(results)]
