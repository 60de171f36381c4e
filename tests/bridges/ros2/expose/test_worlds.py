from __future__ import annotations

import asyncio

import pytest

from seoro.bridges.ros2.expose.worlds import Worlds


async def until_it_waits() -> None:
    for _ in range(3):
        await asyncio.sleep(0.0)


@pytest.mark.parametrize("number", [0, 7])  # nodes may not number their worlds
async def test_who_loads_a_world_waits_until_it_is_exposed(number: int) -> None:
    worlds = Worlds()
    before = asyncio.create_task(worlds.be_exposed(worlds.order, number))
    await until_it_waits()
    assert not before.done()
    changing = asyncio.create_task(worlds.change())
    await asyncio.wait_for(before, 5.0)
    order = worlds.order
    later = asyncio.create_task(worlds.change())
    await until_it_waits()
    assert not changing.done()
    await asyncio.wait_for(worlds.be_exposed(order, number), 5.0)  # which is over at once: another was ordered
    await asyncio.wait_for(changing, 5.0)
    assert not later.done()
    after = asyncio.create_task(worlds.be_exposed(worlds.order, number))
    await asyncio.wait_for(later, 5.0)
    after.cancel()


async def test_a_world_is_exposed_until_the_node_tells_of_a_later_one() -> None:
    worlds = Worlds()
    worlds.tell(3)  # which the node was asked for after that, so that it is known
    exposed = asyncio.create_task(worlds.be_exposed(0, 4))
    worlds.tell(4)
    await until_it_waits()
    assert not exposed.done()
    worlds.tell(5)
    await asyncio.wait_for(exposed, 5.0)
