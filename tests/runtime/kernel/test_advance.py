"""`TimeAdvance` alone: passing, standing and abandoned time."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

import pytest

from seoro.runtime.kernel.advance import SKIPS, TimeAdvance
from seoro.runtime.kernel.clock import Clock, RealClock, VirtualClock
from seoro.runtime.kernel.timers import Timer, TimerQueue


class Reports:
    """Reports of the time advance."""

    def __init__(self) -> None:
        self.stuck = 0
        self.errors: list[Exception] = []

    def count_stuck(self) -> None:
        self.stuck += 1


class HangingClock(VirtualClock):
    """A clock whose time never passes."""

    async def pass_time(self, due: float | None, interrupt: asyncio.Event) -> None:
        await asyncio.get_running_loop().create_future()


class FailingClock(VirtualClock):
    """A clock that fails."""

    async def pass_time(self, due: float | None, interrupt: asyncio.Event) -> None:
        raise ConnectionError("gone")


@pytest.fixture
def reports() -> Reports:
    return Reports()


@pytest.fixture
def timers() -> TimerQueue:
    timers = TimerQueue()
    timers.add(2.0, Timer(lambda: None))
    return timers


def advance_of(clock: Clock, timers: TimerQueue, reports: Reports) -> TimeAdvance:
    return TimeAdvance(clock, timers, reports.count_stuck, reports.errors.append)


async def is_waiting(passing: asyncio.Task[None]) -> bool:
    """Return whether it still waits after some turns of the event loop."""
    for _ in range(5):
        await asyncio.sleep(0)
    return not passing.done()


async def ends_when(passing: asyncio.Task[None], act: Callable[[], None]) -> bool:
    """Return whether it waits until a call."""
    waits = await is_waiting(passing)
    act()
    async with asyncio.timeout(30.0):
        await passing
    return waits


async def test_time_advances_to_the_next_deadline(timers: TimerQueue, reports: Reports) -> None:
    clock = VirtualClock()
    await advance_of(clock, timers, reports).pass_time(False)
    assert clock.now() == 2.0


async def test_time_skips_to_the_next_deadline_but_yields_to_other_tasks(
    timers: TimerQueue, reports: Reports
) -> None:
    clock = VirtualClock()
    advance = advance_of(clock, timers, reports)
    assert [advance.skip() for _ in range(SKIPS + 1)] == [True] * SKIPS + [False]
    advance.begin()
    assert advance.skip()
    assert clock.now() == 2.0


async def test_a_slow_clock_does_not_skip(timers: TimerQueue, reports: Reports) -> None:
    assert not advance_of(RealClock(), timers, reports).skip()


async def test_time_does_not_skip_without_a_deadline(reports: Reports) -> None:
    assert not advance_of(VirtualClock(), TimerQueue(), reports).skip()


async def test_virtual_time_waits_for_a_task_outside(timers: TimerQueue, reports: Reports) -> None:
    clock = VirtualClock()
    advance = advance_of(clock, timers, reports)
    passing = asyncio.ensure_future(advance.pass_time(True))
    assert await ends_when(passing, advance.interrupt)
    assert (clock.now(), reports.stuck) == (0.0, 0)


async def test_a_stuck_run_is_reported_once(reports: Reports) -> None:
    advance = advance_of(VirtualClock(), TimerQueue(), reports)
    await advance.pass_time(False)
    assert reports.stuck == 1
    passing = asyncio.ensure_future(advance.pass_time(False))
    assert await ends_when(passing, advance.interrupt)
    assert reports.stuck == 1


async def test_a_run_that_expects_a_report_is_not_stuck(reports: Reports) -> None:
    advance = advance_of(VirtualClock(), TimerQueue(), reports)
    advance.expected += 1
    passing = asyncio.ensure_future(advance.pass_time(False))
    assert await ends_when(passing, advance.interrupt)
    assert reports.stuck == 0


async def test_a_handled_arrival_is_dropped(reports: Reports) -> None:
    advance = advance_of(RealClock(), TimerQueue(), reports)
    advance.interrupt()
    advance.clear()
    passing = asyncio.ensure_future(advance.pass_time(False))
    assert await ends_when(passing, advance.interrupt)


async def test_time_stands_still_after_the_clock_has_failed(timers: TimerQueue, reports: Reports) -> None:
    advance = advance_of(FailingClock(), timers, reports)
    await advance.pass_time(False)
    assert [str(error) for error in reports.errors] == ["gone"]
    assert advance.has_failed and not advance.skip()
    passing = asyncio.ensure_future(advance.pass_time(False))
    assert await ends_when(passing, advance.interrupt)
    assert len(reports.errors) == 1


async def test_a_hanging_clock_is_abandoned_without_a_report(
    timers: TimerQueue, reports: Reports, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("seoro.runtime.kernel.advance.PATIENCE", 0.0)
    advance = advance_of(HangingClock(), timers, reports)
    advance.cut_grace()  # nothing is passing yet
    passing = asyncio.ensure_future(advance.pass_time(False))
    assert await ends_when(passing, advance.cut_grace)
    assert advance.has_failed
    assert reports.errors == []
