"""Waiting for what changes."""

from __future__ import annotations

import anyio
import pytest

from seoro.concurrency.condition import Condition

pytestmark = pytest.mark.anyio


class Count:
    """Something that changes."""

    def __init__(self) -> None:
        self.changes = Condition()
        self.value = 0

    def up(self) -> None:
        self.value += 1
        self.changes.notify_all()


async def test_a_condition_that_holds_is_not_awaited() -> None:
    with anyio.fail_after(0):
        assert await Condition().wait_for(lambda: "found") == "found"


async def test_all_waiting_tasks_check_after_each_change_and_return_their_result() -> None:
    count, found = Count(), []

    async def reach(target: int) -> None:
        found.append(await count.changes.wait_for(lambda: [count.value] if count.value >= target else None))

    with anyio.fail_after(30.0):
        async with anyio.create_task_group() as tasks:
            for target in (3, 1, 3):
                tasks.start_soon(reach, target)
            for _ in range(3):
                await anyio.wait_all_tasks_blocked()
                count.up()
    assert found == [[1], [3], [3]]


async def test_a_change_before_the_wait_is_not_waited_for() -> None:
    changes = Condition()
    changes.notify_all()
    with pytest.raises(TimeoutError):
        with anyio.fail_after(0.01):
            await changes.wait()


async def test_a_timeout_of_one_task_does_not_affect_others() -> None:
    count = Count()
    with anyio.fail_after(30.0):
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(count.changes.wait_for, lambda: count.value)
            with pytest.raises(TimeoutError):
                await count.changes.wait_for(lambda: count.value, 0.01)
            count.up()


async def test_the_first_waiting_task_is_announced() -> None:
    waits: list[bool] = []
    condition = Condition(lambda: waits.append(condition.is_awaited))
    with anyio.fail_after(30.0):
        async with anyio.create_task_group() as tasks:
            for _ in range(2):
                tasks.start_soon(condition.wait)
            await anyio.wait_all_tasks_blocked()
            condition.notify_all()
    assert (waits, condition.is_awaited) == ([True], False)
