"""`TimerQueue` alone."""

from seoro.runtime.kernel.timers import Timer, TimerQueue


def nothing() -> None:
    pass


def test_entries_come_by_their_times_then_as_they_were_added() -> None:
    timers = TimerQueue()
    first, second, third = Timer(nothing), Timer(nothing), Timer(nothing)
    timers.add(2.0, third)
    timers.add(0.1 + 0.2, first)
    timers.add(0.3, second)
    assert timers.next_due == 0.3
    assert timers.take(0.2) is None
    assert [timers.take(3.0) for _ in range(4)] == [first, second, third, None]


def test_finished_timers_are_not_due() -> None:
    timers = TimerQueue()
    timer = Timer(nothing)
    timers.add(1.0, timer)
    timer.over = True
    assert timers.next_due is None


def test_finished_timers_do_not_accumulate() -> None:
    timers = TimerQueue()
    for _ in range(100_000):
        timers.add(3600.0, Timer(nothing, over=True))
    timers.add(1.0, Timer(nothing))
    assert len(timers._entries) < 3_000
    assert timers.next_due == 1.0


def test_the_length_of_a_timer_queue_counts_pending_timers() -> None:
    timers = TimerQueue()
    entries = [Timer(nothing) for _ in range(3)]
    for entry in entries:
        timers.add(1.0, entry)
    entries[0].over = True
    timers.take(1.0)
    assert len(timers) == 1
