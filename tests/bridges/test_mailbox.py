"""What waits for the event loop."""

import asyncio
import threading

import anyio
import pytest

from seoro.bridges.session.mailbox import LATEST, Bound, Closed, Mailbox


async def test_messages_are_taken_in_their_order() -> None:
    mailbox: Mailbox[int] = Mailbox(Bound(10))
    for number in range(3):
        assert mailbox.put(number, 1)
    assert [await mailbox.take() for _ in range(3)] == [0, 1, 2]
    assert mailbox.take_now() is None


async def test_messages_of_other_threads_wake_the_one_who_waits() -> None:
    mailbox: Mailbox[int] = Mailbox(Bound(1000))

    def produce() -> None:
        for number in range(500):
            mailbox.put(number, 1)

    thread = threading.Thread(target=produce)
    with anyio.fail_after(5):
        waiting = asyncio.create_task(mailbox.take())
        await asyncio.sleep(0)
        thread.start()
        assert await waiting == 0
        assert [await mailbox.take() for _ in range(499)] == list(range(1, 500))
    thread.join()


async def test_many_messages_are_one_wake_up(monkeypatch: pytest.MonkeyPatch) -> None:
    mailbox: Mailbox[int] = Mailbox(Bound(1000))
    wakes: list[object] = []
    monkeypatch.setattr(mailbox._loop, "call_soon_threadsafe", wakes.append)
    for number in range(100):
        mailbox.put(number, 1)
    assert len(wakes) == 1


async def test_who_waits_without_a_task_is_called_once_when_a_message_arrives() -> None:
    mailbox: Mailbox[int] = Mailbox(Bound(10))
    calls: list[str] = []
    mailbox.when_arrived(lambda: calls.append("called"))
    await asyncio.sleep(0)
    assert not calls
    for number in range(3):
        mailbox.put(number, 1)
        await asyncio.sleep(0)
    assert (calls, mailbox.take_now()) == (["called"], 0)


async def test_who_waits_is_called_also_if_there_is_a_message_or_there_will_be_none() -> None:
    mailbox: Mailbox[int] = Mailbox(Bound(10))
    calls: list[str] = []
    mailbox.put(0, 1)
    await asyncio.sleep(0)
    mailbox.when_arrived(lambda: calls.append("there is one"))
    await asyncio.sleep(0)
    mailbox.take_now()
    mailbox.when_arrived(lambda: calls.append("it is closed"))
    mailbox.close()
    await asyncio.sleep(0)
    mailbox.when_arrived(lambda: calls.append("it was closed"))
    await asyncio.sleep(0)
    assert calls == ["there is one", "it is closed", "it was closed"]


async def test_those_who_give_up_waiting_leave_nothing() -> None:
    mailbox: Mailbox[int] = Mailbox(Bound(10))
    for _ in range(5):
        with anyio.move_on_after(0):
            await mailbox.take()
    assert not mailbox._calls


async def test_the_oldest_are_lost_and_counted() -> None:
    mailbox: Mailbox[int] = Mailbox(Bound(3))
    for number in range(10):
        mailbox.put(number, 1)
    assert (mailbox.lost, len(mailbox)) == (7, 3)
    assert await mailbox.take() == 7


async def test_the_newest_are_lost_where_that_is_said() -> None:
    mailbox: Mailbox[int] = Mailbox(Bound(3, lose="newest"))
    assert [mailbox.put(number, 1) for number in range(5)] == [True, True, True, False, False]
    assert mailbox.lost == 2
    assert await mailbox.take() == 0


async def test_bytes_are_bounded_but_a_single_message_may_be_larger() -> None:
    mailbox: Mailbox[str] = Mailbox(Bound(100, size=10))
    mailbox.put("a", 6)
    mailbox.put("b", 6)
    assert (mailbox.lost, await mailbox.take()) == (1, "b")
    mailbox.put("large", 1000)
    assert await mailbox.take() == "large"


async def test_the_latest_is_all_that_some_want() -> None:
    mailbox: Mailbox[int] = Mailbox(LATEST)
    for number in range(5):
        mailbox.put(number, 1)
    assert await mailbox.take() == 4


async def test_what_waits_can_be_taken_after_the_end() -> None:
    mailbox: Mailbox[int] = Mailbox(Bound(10))
    mailbox.put(1, 1)
    mailbox.close()
    assert not mailbox.put(2, 1)
    assert [number async for number in mailbox] == [1]
    with pytest.raises(Closed):
        await mailbox.take()


async def test_waiting_ends_with_the_mailbox() -> None:
    mailbox: Mailbox[int] = Mailbox(Bound(10))
    waiting = asyncio.create_task(mailbox.take())
    await asyncio.sleep(0)
    mailbox.close()
    with pytest.raises(Closed):
        await waiting


async def test_a_reader_with_a_backlog_leaves_turns_to_other_tasks() -> None:
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
def test_a_mailbox_holds_something(bound: tuple[int, int]) -> None:
    with pytest.raises(ValueError, match="at least one"):
        Bound(*bound)
