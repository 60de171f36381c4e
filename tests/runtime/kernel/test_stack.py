"""Coroutines that descend to others, to any depth."""

import asyncio
import sys
from collections.abc import Coroutine
from typing import Any

import pytest

from seoro.runtime.kernel.stack import carried, descend


async def down(levels: int) -> int:
    if levels == 0:
        await asyncio.sleep(0)
        return 0
    return 1 + await descend(down(levels - 1))


async def test_depth_is_not_limited_by_the_stack() -> None:
    depth = 10 * sys.getrecursionlimit()
    assert await carried(down(depth)) == depth


async def failing() -> None:
    await asyncio.sleep(0)
    raise ValueError("down there")


async def test_exceptions_reach_the_caller_of_descend() -> None:
    async def outer() -> str:
        try:
            await descend(failing())
        except ValueError as error:
            return str(error)
        return "nothing"

    assert await carried(outer()) == "down there"


async def test_exceptions_leave_the_outermost() -> None:
    async def outer() -> None:
        await descend(failing())

    with pytest.raises(ValueError, match="down there"):
        await carried(outer())


async def test_a_cancellation_reaches_the_innermost_first() -> None:
    seen: list[str] = []

    async def noting(name: str, inner: Coroutine[Any, Any, Any]) -> None:
        try:
            await descend(inner)
        except asyncio.CancelledError:
            seen.append(name)
            raise

    async def run() -> None:
        await carried(noting("outer", noting("inner", asyncio.sleep(3600))))

    task = asyncio.create_task(run())
    await asyncio.sleep(0)
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task
    assert seen == ["inner", "outer"]
