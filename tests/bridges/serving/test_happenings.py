"""What has happened at a node: told after a number, waited for, and refused where it is not known."""

from __future__ import annotations

import anyio
import pytest

from seoro.bridges import wire
from seoro.bridges.serving.happenings import HappeningLog
from seoro.bridges.wire.refusal import RequestRefused

pytestmark = pytest.mark.anyio


def contact(name: str) -> wire.Contact:
    return wire.Contact(time=0.0, first=name, second="wall")


def names(told: wire.Happenings) -> list[str]:
    return [each.contact.first for each in told.happenings if each.contact is not None]


async def test_everything_after_a_number_is_told_again_and_again() -> None:
    log = HappeningLog()
    for name in "abc":
        log.tell(contact=contact(name))
    told = await log.after(wire.AwaitHappenings(since=1))
    assert (told.number, names(told)) == (3, ["b", "c"])
    assert names(await log.after(wire.AwaitHappenings(since=1))) == ["b", "c"]
    assert (await log.after(wire.AwaitHappenings(since=3))).happenings == ()


async def test_what_happens_is_told_at_once_to_those_who_wait() -> None:
    log, told = HappeningLog(), []

    async def wait() -> None:
        told.append(names(await log.after(wire.AwaitHappenings(wait=10.0))))

    with anyio.fail_after(2.0):
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(wait)
            await anyio.wait_all_tasks_blocked()
            log.tell(contact=contact("a"))
    assert told == [["a"]]


async def test_numbers_of_another_start_and_what_is_not_kept_are_refused() -> None:
    log = HappeningLog(kept=2)
    with pytest.raises(RequestRefused, match="0 things have happened since this node was started, not 5"):
        await log.after(wire.AwaitHappenings(since=5))
    for name in "abc":
        log.tell(contact=contact(name))
    with pytest.raises(RequestRefused, match="only the last 2 things"):
        await log.after(wire.AwaitHappenings(since=0))
