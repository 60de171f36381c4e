"""Those who follow runs get what comes at once, as much as there is room for, until there is something else."""

import asyncio

from seoro.executor.watching import PERIOD, SHARE, Pace, Watch, Watches


class Sent:
    """What a watch was sent."""

    def __init__(self) -> None:
        self.parts: list[tuple[int, bytes]] = []

    def send(self, start: int, lines: bytes) -> None:
        self.parts.append((start, lines))


async def test_what_comes_is_sent_at_once() -> None:
    sent, watches = Sent(), Watches(Pace())
    watch = Watch(5, 100, sent.send)
    with watches.having(watch):
        watches.grow(5, b"one\n")
    watches.grow(9, b"two\n")
    assert sent.parts == [(5, b"one\n")]
    assert watch.at == 9
    assert not watch.over.is_set()


async def test_an_executor_with_much_to_send_sends_it_in_large_parts() -> None:
    pace = Pace()
    sent, late, watches = Sent(), Sent(), Watches(pace)
    now = asyncio.get_running_loop().time()
    pace.took(now, now + 3600.0)
    watch = Watch(0, 100, sent.send)
    with watches.having(watch):
        for number in range(5):
            watches.grow(2 * number, b"x\n")
        assert not sent.parts
        while watch.at < 10:
            await asyncio.sleep(0.0)
        watches.grow(10, b"x\n")
        with watches.having(Watch(12, 100, late.send)):
            watches.grow(12, b"y\n")
            while watch.at < 14:
                await asyncio.sleep(0.0)
    assert sent.parts == [(0, b"x\nx\nx\nx\nx\n"), (10, b"x\n"), (12, b"y\n")]
    assert late.parts == [(12, b"y\n")]


def test_parts_wait_once_sending_them_takes_more_than_its_share() -> None:
    pace, took = Pace(), 0.001 * SHARE
    assert pace.wait(1.0) == 0.0
    pace.took(1.0, 1.0 + took)
    assert pace.wait(1.0 + took) > 0.0
    assert pace.wait(1.0011) == 0.0
    for _ in range(100):
        pace.took(2.0, 2.0 + took)
    assert pace.wait(2.0) == PERIOD
    assert pace.wait(3.0) == 0.0


def test_no_more_is_sent_than_there_is_room_for() -> None:
    sent = Sent()
    watch = Watch(0, 6, sent.send)
    watch.grow(0, b"one\n")
    watch.grow(4, b"two\n")
    watch.grow(8, b"x\n")
    assert sent.parts == [(0, b"one\n")]
    assert watch.at == 4
    assert watch.over.is_set()


def test_a_watch_that_lacks_something_is_over() -> None:
    sent = Sent()
    watch = Watch(0, 100, sent.send)
    watch.grow(4, b"two\n")
    assert watch.over.is_set()
    assert not sent.parts


def test_a_watch_is_over_when_the_state_of_the_run_changes() -> None:
    watches, watch = Watches(Pace()), Watch(0, 100, Sent().send)
    with watches.having(watch):
        watches.turn()
    assert watch.over.is_set()


async def test_one_who_is_gone_holds_nobody_up() -> None:
    def fail(_start: int, _lines: bytes) -> None:
        raise RuntimeError("the session is closed")

    sent, watches = Sent(), Watches(Pace())
    gone, there = Watch(0, 100, fail), Watch(0, 100, sent.send)
    with watches.having(gone), watches.having(there):
        watches.grow(0, b"one\n")
    assert gone.over.is_set()
    assert gone.at == 0
    assert sent.parts == [(0, b"one\n")]
