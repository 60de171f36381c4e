"""Those who follow runs get what comes at once, as much as there is room for, until there is something else."""

from seoro.executor.watching import Watch, Watches


class Sent:
    """What a watch was sent."""

    def __init__(self) -> None:
        self.parts: list[tuple[int, bytes]] = []

    def send(self, start: int, lines: bytes) -> None:
        self.parts.append((start, lines))


def test_what_comes_is_sent_at_once() -> None:
    sent, watches = Sent(), Watches()
    watch = Watch(5, 100, sent.send)
    with watches.having(watch):
        watches.grow(5, b"one\n")
        watches.grow(9, b"two\n")
    watches.grow(13, b"three\n")
    assert sent.parts == [(5, b"one\n"), (9, b"two\n")]
    assert watch.at == 13
    assert not watch.over.is_set()


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
    watches, watch = Watches(), Watch(0, 100, Sent().send)
    with watches.having(watch):
        watches.turn()
    assert watch.over.is_set()


def test_one_who_is_gone_holds_nobody_up() -> None:
    def fail(_start: int, _lines: bytes) -> None:
        raise RuntimeError("the session is closed")

    sent, watches = Sent(), Watches()
    gone, there = Watch(0, 100, fail), Watch(0, 100, sent.send)
    with watches.having(gone), watches.having(there):
        watches.grow(0, b"one\n")
    assert gone.over.is_set()
    assert gone.at == 0
    assert sent.parts == [(0, b"one\n")]
