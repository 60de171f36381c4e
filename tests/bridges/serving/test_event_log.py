"""Event log of a node: events after a number, waits, and refusals of unknown numbers."""

from __future__ import annotations

import anyio
import pytest

from seoro.bridges import wire
from seoro.bridges.serving.event_log import EventLog
from seoro.bridges.wire.refusal import RequestRefused

pytestmark = pytest.mark.anyio


def contact(name: str) -> wire.Contact:
    return wire.Contact(time=0.0, first=name, second="wall")


def names(reported: wire.LoggedEvents) -> list[str]:
    return [each.contact.first for each in reported.events if each.contact is not None]


async def test_events_after_a_number_are_returned_repeatedly() -> None:
    log = EventLog()
    for name in "abc":
        log.add(contact=contact(name))
    reported = await log.after(wire.AwaitEvents(since=1))
    assert (reported.number, names(reported)) == (3, ["b", "c"])
    assert names(await log.after(wire.AwaitEvents(since=1))) == ["b", "c"]
    assert (await log.after(wire.AwaitEvents(since=3))).events == ()


async def test_waiting_clients_receive_an_event_at_once() -> None:
    log, reported = EventLog(), []

    async def wait() -> None:
        reported.append(names(await log.after(wire.AwaitEvents(wait=10.0))))

    with anyio.fail_after(30.0):
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(wait)
            await anyio.wait_all_tasks_blocked()
            log.add(contact=contact("a"))
    assert reported == [["a"]]


async def test_unknown_and_dropped_event_numbers_are_refused() -> None:
    log = EventLog(kept=2)
    with pytest.raises(RequestRefused, match="unknown event 5; the last event of this node is 0"):
        await log.after(wire.AwaitEvents(since=5))
    for name in "abc":
        log.add(contact=contact(name))
    with pytest.raises(RequestRefused, match="only the last 2 events"):
        await log.after(wire.AwaitEvents(since=0))
