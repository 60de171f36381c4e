"""Clients that follow a run receive new records at once, up to a size, until the run changes."""

import asyncio

from seoro.executor.runs.tail import PERIOD, SHARE, Pace, Watch, Watches


class Sent:
    """Parts that a watch received."""

    def __init__(self) -> None:
        self.parts: list[tuple[int, bytes]] = []

    def send(self, start: int, lines: bytes) -> None:
        self.parts.append((start, lines))


async def test_new_records_are_sent_at_once() -> None:
    sent, watches = Sent(), Watches(Pace())
    watch = Watch(5, 100, sent.send)
    with watches.added(watch):
        watches.grow(5, b"one\n")
    watches.grow(9, b"two\n")
    assert sent.parts == [(5, b"one\n")]
    assert watch.at == 9
    assert not watch.over.is_set()


async def test_a_busy_executor_sends_large_parts() -> None:
    pace = Pace()
    sent, late, watches = Sent(), Sent(), Watches(pace)
    now = asyncio.get_running_loop().time()
    pace.note_duration(now, now + 3600.0)
    watch = Watch(0, 100, sent.send)
    with watches.added(watch):
        for number in range(5):
            watches.grow(2 * number, b"x\n")
        assert not sent.parts
        while watch.at < 10:
            await asyncio.sleep(0.0)
        watches.grow(10, b"x\n")
        with watches.added(Watch(12, 100, late.send)):
            watches.grow(12, b"y\n")
            while watch.at < 14:
                await asyncio.sleep(0.0)
    assert sent.parts == [(0, b"x\nx\nx\nx\nx\n"), (10, b"x\n"), (12, b"y\n")]
    assert late.parts == [(12, b"y\n")]


def test_parts_wait_once_sending_them_takes_more_than_its_share() -> None:
    pace, took = Pace(), 0.001 * SHARE
    assert pace.wait(1.0) == 0.0
    pace.note_duration(1.0, 1.0 + took)
    assert pace.wait(1.0 + took) > 0.0
    assert pace.wait(1.0011) == 0.0
    for _ in range(100):
        pace.note_duration(2.0, 2.0 + took)
    assert pace.wait(2.0) == PERIOD
    assert pace.wait(3.0) == 0.0


def test_a_watch_sends_no_more_than_its_limit() -> None:
    sent = Sent()
    watch = Watch(0, 6, sent.send)
    watch.grow(0, b"one\n")
    watch.grow(4, b"two\n")
    watch.grow(8, b"x\n")
    assert sent.parts == [(0, b"one\n")]
    assert watch.at == 4
    assert watch.over.is_set()


def test_a_watch_with_a_gap_ends() -> None:
    sent = Sent()
    watch = Watch(0, 100, sent.send)
    watch.grow(4, b"two\n")
    assert watch.over.is_set()
    assert not sent.parts


def test_a_watch_ends_when_the_state_of_the_run_changes() -> None:
    watches, watch = Watches(Pace()), Watch(0, 100, Sent().send)
    with watches.added(watch):
        watches.end_all()
    assert watch.over.is_set()


async def test_a_failed_watch_delays_no_other() -> None:
    def fail(_start: int, _lines: bytes) -> None:
        raise RuntimeError("the session is closed")

    sent, watches = Sent(), Watches(Pace())
    gone, there = Watch(0, 100, fail), Watch(0, 100, sent.send)
    with watches.added(gone), watches.added(there):
        watches.grow(0, b"one\n")
    assert gone.over.is_set()
    assert gone.at == 0
    assert sent.parts == [(0, b"one\n")]
