"""What is due when."""

from seoro.runtime.flows import Flow, Waiter
from seoro.runtime.timetable import Timer, Timetable


def nothing() -> None:
    pass


def test_entries_come_by_their_times_then_as_they_were_added() -> None:
    table = Timetable()
    first, second, third = Timer(nothing), Timer(nothing), Timer(nothing)
    table.add(2.0, third)
    table.add(0.1 + 0.2, first)
    table.add(0.3, second)
    assert table.next_due == 0.3
    assert table.take(0.2) is None
    assert [table.take(3.0) for _ in range(4)] == [first, second, third, None]


def test_what_is_over_is_not_due() -> None:
    table = Timetable()
    waiter = Waiter(Flow((), None, (0, ())))
    table.add(1.0, waiter)
    waiter.over = True
    assert table.next_due is None


def test_what_is_over_does_not_pile_up() -> None:
    table = Timetable()
    for _ in range(100_000):
        table.add(3600.0, Timer(nothing, over=True))
    table.add(1.0, Timer(nothing))
    assert len(table._entries) < 3_000
    assert table.next_due == 1.0
