"""Mailboxes of the event loop."""

import asyncio
import threading

import anyio
import pytest

from seoro.bridges.session.mailbox import LATEST, Bound, Closed, Mailbox


async def test_messages_are_received_in_order() -> None:
    mailbox: Mailbox[int] = Mailbox(Bound(10))
    for number in range(3):
        assert mailbox.put(number, 1)
    assert [await mailbox.get() for _ in range(3)] == [0, 1, 2]
    assert mailbox.get_nowait() is None


async def test_messages_of_other_threads_wake_the_waiting_task() -> None:
    mailbox: Mailbox[int] = Mailbox(Bound(1000))

    def produce() -> None:
        for number in range(500):
            mailbox.put(number, 1)

    thread = threading.Thread(target=produce)
    with anyio.fail_after(30.0):
        waiting = asyncio.create_task(mailbox.get())
        await asyncio.sleep(0)
        thread.start()
        assert await waiting == 0
        assert [await mailbox.get() for _ in range(499)] == list(range(1, 500))
    thread.join()


@pytest.mark.parametrize("is_awaited", [True, False])
async def test_many_messages_wake_a_waiting_reader_once(is_awaited: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    mailbox: Mailbox[int] = Mailbox(Bound(1000))
    wakes: list[object] = []
    monkeypatch.setattr(mailbox._loop, "call_soon_threadsafe", wakes.append)
    if is_awaited:
        mailbox.on_arrival(lambda: None)
    for number in range(100):
        mailbox.put(number, 1)
    assert len(wakes) == is_awaited


async def test_a_callback_is_called_once_when_a_message_arrives() -> None:
    mailbox: Mailbox[int] = Mailbox(Bound(10))
    calls: list[str] = []
    mailbox.on_arrival(lambda: calls.append("called"))
    await asyncio.sleep(0)
    assert not calls
    for number in range(3):
        mailbox.put(number, 1)
        await asyncio.sleep(0)
    assert (calls, mailbox.get_nowait()) == (["called"], 0)


async def test_a_callback_is_called_if_a_message_waits_or_the_mailbox_closes() -> None:
    mailbox: Mailbox[int] = Mailbox(Bound(10))
    calls: list[str] = []
    mailbox.put(0, 1)
    await asyncio.sleep(0)
    mailbox.on_arrival(lambda: calls.append("there is one"))
    await asyncio.sleep(0)
    mailbox.get_nowait()
    mailbox.on_arrival(lambda: calls.append("it is closed"))
    mailbox.close()
    await asyncio.sleep(0)
    mailbox.on_arrival(lambda: calls.append("it was closed"))
    await asyncio.sleep(0)
    assert calls == ["there is one", "it is closed", "it was closed"]


async def test_cancelled_waits_leave_no_callbacks() -> None:
    mailbox: Mailbox[int] = Mailbox(Bound(10))
    for _ in range(5):
        with anyio.move_on_after(0):
            await mailbox.get()
    assert not mailbox._calls


async def test_a_full_mailbox_drops_and_counts_the_oldest_messages() -> None:
    mailbox: Mailbox[int] = Mailbox(Bound(3))
    for number in range(10):
        mailbox.put(number, 1)
    assert (mailbox.dropped, len(mailbox)) == (7, 3)
    assert await mailbox.get() == 7


async def test_a_full_mailbox_drops_the_newest_messages_on_request() -> None:
    mailbox: Mailbox[int] = Mailbox(Bound(3, drop="newest"))
    assert [mailbox.put(number, 1) for number in range(5)] == [True, True, True, False, False]
    assert mailbox.dropped == 2
    assert await mailbox.get() == 0


async def test_a_size_bound_admits_a_single_larger_message() -> None:
    mailbox: Mailbox[str] = Mailbox(Bound(100, size=10))
    mailbox.put("a", 6)
    mailbox.put("b", 6)
    assert (mailbox.dropped, await mailbox.get()) == (1, "b")
    mailbox.put("large", 1000)
    assert await mailbox.get() == "large"


async def test_a_mailbox_may_keep_the_latest_message_only() -> None:
    mailbox: Mailbox[int] = Mailbox(LATEST)
    for number in range(5):
        mailbox.put(number, 1)
    assert await mailbox.get() == 4


async def test_queued_messages_are_received_after_the_mailbox_closes() -> None:
    mailbox: Mailbox[int] = Mailbox(Bound(10))
    mailbox.put(1, 1)
    mailbox.close()
    assert not mailbox.put(2, 1)
    assert [number async for number in mailbox] == [1]
    with pytest.raises(Closed):
        await mailbox.get()


async def test_closing_a_mailbox_ends_a_wait() -> None:
    mailbox: Mailbox[int] = Mailbox(Bound(10))
    waiting = asyncio.create_task(mailbox.get())
    await asyncio.sleep(0)
    mailbox.close()
    with pytest.raises(Closed):
        await waiting


async def test_a_reader_with_a_backlog_yields_to_other_tasks() -> None:
    box: Mailbox[int] = Mailbox(Bound(10))
    for number in range(10):
        box.put(number, 1)
    box.close()
    waiting: list[int] = []
    other = asyncio.create_task(_watch(box, waiting))
    assert [message async for message in box] == list(range(10))
    other.cancel()
    assert len(waiting) >= 10


async def _watch(box: Mailbox[int], waiting: list[int]) -> None:
    while True:
        waiting.append(len(box))
        await asyncio.sleep(0)


@pytest.mark.parametrize("bound", [(0, 1), (1, 0)])
def test_a_mailbox_needs_a_positive_bound(bound: tuple[int, int]) -> None:
    with pytest.raises(ValueError, match="expected at least 1"):
        Bound(*bound)
