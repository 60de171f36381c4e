from __future__ import annotations

import asyncio

import pytest

from seoro.bridges.ros2.expose.node import Worlds


async def until_it_waits() -> None:
    for _ in range(3):
        await asyncio.sleep(0.0)


@pytest.mark.parametrize("number", [0, 7])  # nodes may not number their worlds
async def test_loading_a_world_waits_until_it_is_exposed(number: int) -> None:
    worlds = Worlds()
    before = asyncio.create_task(worlds.wait_replaced(worlds.request, number))
    await until_it_waits()
    assert not before.done()
    changing = asyncio.create_task(worlds.replace())
    await asyncio.wait_for(before, 30.0)
    order = worlds.request
    later = asyncio.create_task(worlds.replace())
    await until_it_waits()
    assert not changing.done()
    await asyncio.wait_for(worlds.wait_replaced(order, number), 30.0)  # ends at once: another world was requested
    await asyncio.wait_for(changing, 30.0)
    assert not later.done()
    after = asyncio.create_task(worlds.wait_replaced(worlds.request, number))
    await asyncio.wait_for(later, 30.0)
    after.cancel()


async def test_a_world_is_exposed_until_the_node_reports_a_later_one() -> None:
    worlds = Worlds()
    worlds.set_number(3)  # the number is known: the node was asked for it
    exposed = asyncio.create_task(worlds.wait_replaced(0, 4))
    worlds.set_number(4)
    await until_it_waits()
    assert not exposed.done()
    worlds.set_number(5)
    await asyncio.wait_for(exposed, 30.0)
