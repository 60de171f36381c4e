"""Alarms: on time, never early, and without leftovers."""

import asyncio
import resource
import time
from pathlib import Path

import anyio
import pytest

from seoro.runtime.kernel.alarm import NEAR, alarm
from seoro.runtime.kernel.clock import RealClock

HALF_WAY = 0.0021  # [s] a time between those to which event loops round


def open_files() -> int:
    """Return the number of open files of this process."""
    return len(list(Path("/proc/self/fd").iterdir()))


async def lateness(delay: float) -> float:
    """Return by how much a wait of the real clock is late [s]."""
    clock = RealClock()
    clock.start()
    await clock.pass_time(delay, asyncio.Event())
    return clock.now() - delay


async def test_a_sleep_ends_in_a_fraction_of_a_millisecond_and_never_early() -> None:
    late = [await lateness(HALF_WAY) for _ in range(50)]
    assert min(late) >= 0.0
    assert min(late) < 0.0008  # the loop alone sleeps for 3 ms


@pytest.mark.parametrize("ago", [0.0, 1.0, 1e9])
async def test_an_alarm_for_a_time_that_has_passed_rings_at_once(ago: float) -> None:
    rung = asyncio.Event()
    with anyio.fail_after(30.0), alarm(time.monotonic() - ago, rung.set):
        await rung.wait()
    assert rung.is_set()


async def test_an_alarm_rings_once_and_only_within_its_block() -> None:
    rings: list[str] = []
    with alarm(time.monotonic(), lambda: rings.append("within")):
        await anyio.sleep(0.02)
    with alarm(time.monotonic() + 0.005, lambda: rings.append("after")):
        pass
    await anyio.sleep(0.02)
    assert rings == ["within"]


async def test_an_alarm_leaves_no_file() -> None:
    before = open_files()
    for _ in range(10):
        with pytest.raises(ZeroDivisionError), alarm(time.monotonic() + 60, lambda: None):
            assert open_files() == before  # it is far away
            raise ZeroDivisionError
    assert open_files() == before


async def test_an_alarm_that_is_near_has_a_file_within_its_block_only() -> None:
    before = open_files()
    for _ in range(10):
        with pytest.raises(ZeroDivisionError), alarm(time.monotonic() + NEAR / 2, lambda: None):
            assert open_files() == before + 1
            raise ZeroDivisionError
    assert open_files() == before


async def test_an_alarm_rings_on_time_that_was_far_away_when_it_was_set() -> None:
    at = time.monotonic() + NEAR + HALF_WAY
    rung, before = asyncio.Event(), open_files()
    with anyio.fail_after(30.0), alarm(at, rung.set):
        assert open_files() == before
        await rung.wait()
        assert time.monotonic() >= at
    assert open_files() == before


async def test_an_alarm_rings_when_no_more_files_can_be_opened() -> None:
    limits = resource.getrlimit(resource.RLIMIT_NOFILE)
    rung = asyncio.Event()
    resource.setrlimit(resource.RLIMIT_NOFILE, (0, limits[1]))
    try:
        with anyio.fail_after(30.0), alarm(time.monotonic() + 0.005, rung.set):
            await rung.wait()
        assert rung.is_set()
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, limits)


async def test_sleep_is_interrupted_before_it_is_due() -> None:
    clock, interrupt = RealClock(), asyncio.Event()
    clock.start()
    async with anyio.create_task_group() as group:
        group.start_soon(clock.pass_time, 60.0, interrupt)
        await anyio.sleep(0.01)
        interrupt.set()
    assert clock.now() < 30.0
