"""Readers of a trace during the run: several, slow, late, and early-ending ones."""

import asyncio
from collections.abc import Callable
from pathlib import Path

import pytest

import seoro
from seoro.runtime.trace.reader import WINDOW

LONG = """import osc.types
import osc.helpers

scenario main:
    do serial:
        wait elapsed(1ms)
        log("one more")
    with:
        repeat({times})
"""
LOGS = 1000  # each makes five records

Load = Callable[[int], seoro.Scenario]


@pytest.fixture
def load(tmp_path: Path) -> Load:
    """Return a function that loads a scenario with a number of logs, one per millisecond."""

    def load_times(times: int) -> seoro.Scenario:
        (tmp_path / "long.osc").write_text(LONG.replace("{times}", str(times)))
        return seoro.load(tmp_path / "long.osc")

    return load_times


async def numbers(run: seoro.Run) -> list[int]:
    """Return the numbers of all records."""
    return [record["seq"] async for record in run.trace()]


async def test_readers_share_a_trace_each_at_its_own_pace(load: Load) -> None:
    async def slow(run: seoro.Run) -> list[int]:
        read = []
        async for record in run.trace():
            read.append(record["seq"])
            if len(read) % 100 == 0:
                await asyncio.sleep(0.001)
        return read

    async with seoro.start(load(LOGS), clock="virtual") as run:
        first, second, third = await asyncio.gather(numbers(run), slow(run), numbers(run))
    assert first == second == third == list(range(len(first)))
    assert len(first) > 3 * WINDOW


async def test_virtual_time_waits_for_a_slow_reader(load: Load) -> None:
    last = {"seq": 0}

    class Watch:
        def record(self, record: dict[str, int]) -> None:
            last["seq"] = record["seq"]

    async with seoro.start(load(LOGS), clock="virtual", observers=[Watch()]) as run:
        async for record in run.trace():
            assert last["seq"] - record["seq"] <= WINDOW + 10  # an instant ends, before time stands still
            if record["seq"] % 500 == 0:
                await asyncio.sleep(0.002)
    assert last["seq"] > 3 * WINDOW


async def test_a_kept_trace_never_waits_and_can_be_read_at_any_time(load: Load) -> None:
    async with seoro.start(load(LOGS), clock="virtual", keep_trace=True) as run:
        reader = run.trace()
        await anext(reader)
        assert (await run.result()).passed
    assert len([record async for record in reader]) > 3 * WINDOW
    assert await numbers(run) == await numbers(run)


async def test_a_short_trace_can_be_read_after_its_end(load: Load) -> None:
    async with seoro.start(load(10), clock="virtual") as run:
        await run.result()
    assert (await numbers(run))[:3] == [0, 1, 2]


async def test_a_reader_that_comes_too_late_is_refused(load: Load) -> None:
    async with seoro.start(load(LOGS), clock="virtual") as run:
        await run.result()
        with pytest.raises(seoro.UsageError, match=f"only the last {WINDOW} are kept") as caught:
            run.trace()
    assert "keep_trace=True" in caught.value.help


async def test_a_reader_that_stops_early_does_not_delay_the_run(load: Load) -> None:
    async with seoro.start(load(LOGS), clock="virtual") as run:
        async for record in run.trace():
            if record["kind"] == "log":
                break
        assert (await run.result()).passed


async def test_a_dropped_reader_no_longer_delays_the_run(load: Load) -> None:
    async with seoro.start(load(LOGS), clock="virtual") as run:
        reader = run.trace()
        await anext(reader)
        waiting = asyncio.ensure_future(run.result())
        await asyncio.sleep(0.1)
        assert not waiting.done()
        del reader
        assert (await waiting).passed


async def test_a_closed_reader_does_not_delay_the_run(load: Load) -> None:
    async with seoro.start(load(LOGS), clock="virtual") as run:
        reader = run.trace()
        await anext(reader)
        await reader.aclose()
        assert (await run.result()).passed


@pytest.mark.parametrize("ending", ["stop", "block", "cancel"])
async def test_a_run_that_waits_for_a_reader_can_be_ended(load: Load, ending: str) -> None:
    async def program() -> seoro.Run:
        async with seoro.start(load(LOGS), clock="virtual") as run:
            runs.append((run, run.trace()))
            started.set()
            await asyncio.sleep(0.05)
            if ending == "stop":
                run.stop("enough")
                await run.result()
            elif ending == "cancel":
                await asyncio.sleep(3600)
        return run

    runs: list[tuple[seoro.Run, seoro.TraceReader]] = []
    started = asyncio.Event()
    task = asyncio.create_task(program())
    await started.wait()
    await asyncio.sleep(0.1)
    task.cancel()
    await asyncio.wait([task], timeout=30)
    [(run, reader)] = runs
    assert task.done()
    assert (await run.result()).status is seoro.RunStatus.CANCELLED
    assert [record async for record in reader][-1]["kind"] == "run.end"


async def test_the_real_clock_waits_for_no_reader(load: Load) -> None:
    async with seoro.start(load(400)) as run:
        reader = run.trace()
        assert (await run.result()).passed
    assert len([record async for record in reader]) > WINDOW  # unread records were kept for it


async def test_memory_is_bounded_without_readers(load: Load) -> None:
    async with seoro.start(load(LOGS), clock="virtual") as run:
        assert (await run.result()).passed
    assert len(run._readers._records) == WINDOW


async def test_a_cancelled_reader_can_continue(load: Load) -> None:
    async with seoro.start(load(3)) as run:
        reader = run.trace()
        read = [(await anext(reader))["seq"]]
        for _ in range(5):
            task = asyncio.ensure_future(anext(reader))
            await asyncio.sleep(0)
            if task.cancel():
                await asyncio.wait([task])
            else:
                read.append((await task)["seq"])
        read += [record["seq"] async for record in reader]
    assert read == list(range(len(read)))
