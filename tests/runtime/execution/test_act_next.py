"""Effects of an application at the start of the next instant, on any clock."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable
from pathlib import Path

import pytest

import seoro
from seoro.runtime.kernel.clock import NEXT, Clock, RealClock, SimulatorClock, VirtualClock
from seoro.runtime.kernel.scheduler import Scheduler
from seoro.runtime.kernel.task import Task
from seoro.runtime.kernel.timers import Timer
from seoro.runtime.trace.reader import ReadClock, Readers


class Server:
    """A simulator with steps of 10 ms."""

    def __init__(self) -> None:
        self.time = 0.0

    async def advance(self, until: float) -> float:
        await asyncio.sleep(0)
        self.time = max(self.time, math.ceil(round(until / 0.01, 9)) * 0.01)
        return self.time


def scheduler_on(clock: Clock) -> Scheduler:
    def wrong(*arguments: object) -> None:
        pytest.fail(f"{arguments}")

    made = Scheduler(clock, wrong, wrong, wrong)
    made.expect(1)  # the application
    return made


async def acted(clock: Clock) -> list[tuple[float, int]]:
    """Return times and numbers of the instants of two successive acts."""
    scheduler, found = scheduler_on(clock), list[tuple[float, int]]()

    async def root(task: Task) -> None:
        await task.sleep(0.02)
        settled.set()
        while len(found) < 2:
            await task.sleep(0.02)

    async def application() -> None:
        await settled.wait()
        for _ in range(2):
            done = asyncio.Event()

            def act(done: asyncio.Event = done) -> None:
                found.append((scheduler.now, scheduler.instant))
                done.set()

            scheduler.act_next(Timer(act))
            await done.wait()

    settled = asyncio.Event()
    scheduler.start_root(root)
    clock.start()
    async with asyncio.TaskGroup() as group:
        group.create_task(scheduler.run())
        group.create_task(application())
    return found


@pytest.mark.parametrize("make", [VirtualClock, RealClock, lambda: SimulatorClock(Server(), math.inf)])
async def test_each_external_act_has_a_new_instant(make: Callable[[], Clock]) -> None:
    first, second = await acted(make())
    assert 0.02 < first[0] < second[0]
    assert first[1] < second[1]


async def test_the_next_instant_of_virtual_time_is_a_nanosecond_away() -> None:
    scheduler, found = scheduler_on(VirtualClock()), list[float]()

    async def root(task: Task) -> None:
        scheduler.act_next(Timer(lambda: found.append(scheduler.now)))
        await task.sleep(1.0)

    scheduler.start_root(root)
    await scheduler.run()
    assert found == [NEXT]


async def test_slow_readers_do_not_delay_the_next_instant() -> None:
    class Full:
        is_full = True

        def record(self, record: object) -> None:
            pass

        def end(self) -> None:
            pass

    readers = Readers(keep_all=True)
    readers.follow(Full())
    clock = ReadClock(VirtualClock(), readers)
    assert not clock.skip(2 * NEXT)
    assert clock.skip(NEXT)
    await clock.pass_time(2 * NEXT, asyncio.Event())
    interrupt = asyncio.Event()
    interrupt.set()
    await clock.pass_time(1.0, interrupt)
    assert clock.now() == 2 * NEXT


ASKING = """import osc.types
scenario main:
    event ask
    event go
    do serial:
        wait elapsed(1s)
        emit ask
        wait @go
"""


async def test_simulated_time_continues_while_a_run_waits_for_its_application(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    server = Server()
    monkeypatch.setattr(
        "seoro.embed.preparation.make_clock",
        lambda *arguments: ReadClock(SimulatorClock(server, math.inf), arguments[3]),
    )
    (tmp_path / "main.osc").write_text(ASKING)
    async with (
        seoro.start(seoro.load(tmp_path / "main.osc"), clock="virtual", external=["go"]) as run,
        run.subscribe("ask") as asks,
    ):
        asked = (await anext(asks)).time
        while run.now < asked + 10.0:
            await asyncio.sleep(0)
        assert run.verdict is None
        emitted = await run.emit("go")
        assert (await run.result()).passed
    assert emitted.time > asked + 10.0


async def test_a_subscription_holds_simulated_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    server = Server()
    monkeypatch.setattr(
        "seoro.embed.preparation.make_clock",
        lambda *arguments: ReadClock(SimulatorClock(server, math.inf), arguments[3]),
    )
    (tmp_path / "main.osc").write_text(ASKING)
    async with (
        seoro.start(seoro.load(tmp_path / "main.osc"), clock="virtual", external=["go"]) as run,
        run.subscribe("ask", capacity=1, on_full="wait") as asks,
    ):
        asked = (await anext(asks)).time
        for _ in range(1000):
            await asyncio.sleep(0)
        assert run.now == asked
        emitted = await run.emit("go")
        assert emitted.time == pytest.approx(asked + 0.01)  # the next step of the simulator
        assert (await run.result()).passed
