"""Declarations while a block lasts."""

import asyncio
import threading

import pytest

from seoro.bridges.session.declaring import declared


@pytest.mark.parametrize("moment", ["make", "undo"])
async def test_a_declaration_is_undone_if_its_task_is_cancelled_meanwhile(moment: str) -> None:
    begun, go_on = asyncio.Event(), threading.Event()
    loop = asyncio.get_running_loop()
    happened: list[str] = []

    def take(name: str) -> str:
        if name == moment:
            loop.call_soon_threadsafe(begun.set)
            go_on.wait()
        happened.append(name)
        return name

    async def use() -> None:
        async with declared(lambda: take("make"), lambda made: take("undo")):
            happened.append("use")

    task = asyncio.ensure_future(use())
    await begun.wait()
    for _ in range(2):
        task.cancel()
        await asyncio.sleep(0)
        await asyncio.sleep(0)
    go_on.set()
    await asyncio.wait({task})
    assert task.cancelled()
    assert happened == (["make", "undo"] if moment == "make" else ["make", "use", "undo"])
