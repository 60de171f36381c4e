"""Waiting for what changes."""

from __future__ import annotations

import anyio
import pytest

from seoro.changes import Changes

pytestmark = pytest.mark.anyio


class Count:
    """Something that changes."""

    def __init__(self) -> None:
        self.changes = Changes()
        self.value = 0

    def up(self) -> None:
        self.value += 1
        self.changes.tell()


async def test_what_holds_already_is_not_waited_for() -> None:
    with anyio.fail_after(0):
        assert await Changes().wait_for(lambda: "found") == "found"


async def test_all_who_wait_look_again_after_each_change_and_get_what_they_found() -> None:
    count, found = Count(), []

    async def reach(target: int) -> None:
        found.append(await count.changes.wait_for(lambda: [count.value] if count.value >= target else None))

    with anyio.fail_after(2):
        async with anyio.create_task_group() as tasks:
            for target in (3, 1, 3):
                tasks.start_soon(reach, target)
            for _ in range(3):
                await anyio.wait_all_tasks_blocked()
                count.up()
    assert found == [[1], [3], [3]]


async def test_a_change_before_the_wait_is_not_waited_for() -> None:
    changes = Changes()
    changes.tell()
    with pytest.raises(TimeoutError):
        with anyio.fail_after(0.01):
            await changes.wait()


async def test_who_gives_up_disturbs_no_other() -> None:
    count = Count()
    with anyio.fail_after(2):
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(count.changes.wait_for, lambda: count.value)
            with pytest.raises(TimeoutError):
                await count.changes.wait_for(lambda: count.value, 0.01)
            count.up()
