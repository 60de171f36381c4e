"""`DeltaCycle` and `Commit` alone."""

from __future__ import annotations

from functools import partial

from seoro.runtime.kernel.clock import VirtualClock
from seoro.runtime.kernel.delta import Commit, DeltaCycle
from seoro.runtime.kernel.scheduler import Scheduler
from seoro.runtime.kernel.task import Task


def take_all(cycle: DeltaCycle) -> None:
    """Take the steps of the present cycle."""
    while cycle.present:
        _, act, _, _ = cycle.present.popleft()
        act()


def test_steps_are_taken_in_the_next_cycle_in_order_of_paths() -> None:
    log: list[str] = []
    cycle = DeltaCycle(None, lambda task: None)
    cycle.add((1,), partial(log.append, "second"))
    cycle.add((0, 5), partial(log.append, "first"))
    assert (cycle.has_next, len(cycle.present), cycle.number) == (True, 0, 0)
    cycle.begin()
    cycle.add((0,), partial(log.append, "of the next cycle"))
    take_all(cycle)
    assert (log, cycle.number, cycle.has_next) == (["first", "second"], 1, True)


def test_steps_of_equal_paths_are_taken_as_they_were_added() -> None:
    log: list[str] = []
    cycle = DeltaCycle(None, lambda task: None)
    for name in "abc":
        cycle.add((0,), partial(log.append, name))
    cycle.begin()
    take_all(cycle)
    assert log == ["a", "b", "c"]


async def test_cancellations_come_before_all_steps_in_order_of_paths() -> None:
    log: list[object] = []
    scheduler = Scheduler(VirtualClock())
    cycle = DeltaCycle(None, lambda task: log.append(task.path))
    cycle.add((), partial(log.append, "step"))
    for path in ((1,), (0,)):
        cycle.cancel(Task(scheduler, path, None, 0))
    assert cycle.has_next
    cycle.begin()
    take_all(cycle)
    assert log == [(0,), (1,), "step"]


def test_the_order_of_steps_can_be_given() -> None:
    log: list[str] = []
    cycle = DeltaCycle(lambda path: -path[0], lambda task: None)
    for index, name in enumerate("abc"):
        cycle.add((index,), partial(log.append, name))
    cycle.begin()
    take_all(cycle)
    assert log == ["c", "b", "a"]


def test_effects_are_committed_once() -> None:
    log: list[str] = []
    commit = Commit(lambda error: None)
    commit.writes.append(((), partial(log.append, "write"), None))
    assert commit.is_due
    commit.run()
    assert not commit.is_due
    commit.run()
    assert log == ["write"]


def test_cancellations_by_a_send_are_of_the_same_commit() -> None:
    log: list[str] = []
    commit = Commit(lambda error: None)

    def send() -> None:
        log.append("send")
        commit.cancellations.append(((), partial(log.append, "cancel"), None))

    commit.sends.append((("channel", ""), send, None))
    commit.run()
    assert log == ["send", "cancel"]


def test_sends_by_a_cancellation_follow_all_cancellations_of_the_commit() -> None:
    log: list[str] = []
    commit = Commit(lambda error: None)

    def cancel() -> None:
        commit.sends.append((("channel", ""), partial(log.append, "send"), None))
        commit.cancellations.append(((), partial(log.append, "cancel more"), None))

    commit.cancellations.append(((), cancel, None))
    commit.closings.append((None, partial(log.append, "closing"), None))
    commit.run()
    assert log == ["cancel more", "send", "closing"]


def test_a_write_of_a_write_is_of_the_next_commit() -> None:
    log: list[str] = []
    commit = Commit(lambda error: None)
    commit.writes.append(((), lambda: commit.writes.append(((), partial(log.append, "again"), None)), None))
    commit.run()
    assert (log, commit.is_due) == ([], True)


def divide_by_zero() -> None:
    raise ZeroDivisionError


def test_an_effect_that_raises_is_reported_and_others_continue() -> None:
    log: list[str] = []
    errors: list[Exception] = []
    commit = Commit(errors.append)
    commit.writes.append(((0,), divide_by_zero, None))
    commit.writes.append(((1,), partial(log.append, "write"), None))
    commit.run()
    assert (log, [type(error) for error in errors]) == (["write"], [ZeroDivisionError])
