"""Several engines as one, and slots that come and go."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable, Sequence
from pathlib import Path

import pytest

from seoro.campaign.coordinator import ATTEMPTS, ATTEMPTS_IF_LOST, Coordinator
from seoro.campaign.engine import Killed, MachineLost, WorkerDied
from seoro.campaign.engines import Engines
from seoro.campaign.planner import Planner
from seoro.campaign.runs import End, Planned, Row
from seoro.campaign.space.space import Space
from tests.campaign.test_planner import Counting, campaign


class Machine:
    """Engine with slots that a test sets."""

    def __init__(self, name: str, slots: int) -> None:
        self.name = name
        self.slots = slots
        self.active = 0
        self.most = 0
        self.lost_chunks = 0  # that will be lost, instead of carried out
        self.loss: type[WorkerDied] = MachineLost
        self._changed = asyncio.Event()
        self._stopped = False

    async def slots_changed(self) -> None:
        await self._changed.wait()
        self._changed.clear()

    def set(self, slots: int) -> None:
        self.slots = slots
        self._changed.set()

    async def run(self, runs: Sequence[Planned]) -> AsyncIterator[Row]:
        self.active += 1
        self.most = max(self.most, self.active)
        try:
            for each in runs:
                await asyncio.sleep(0)
                if self.lost_chunks or self._stopped:
                    self.lost_chunks -= 1
                    raise self.loss(f"{self.name} is lost")
                yield Row(each.number, "", each.variant, each.repeat, each.seed, End.PASSED, worker=self.name)
        finally:
            self.active -= 1

    def stop(self) -> None:
        self._stopped = True


async def carry_out(
    folder: Path, engine: Engines, count: int, at: int = 0, do: Callable[[], None] = lambda: None
) -> list[Row]:
    """Carry out runs; call `do` after the row number `at`."""
    opened = campaign(folder, runs=count)
    rows: list[Row] = []

    def take(row: Row) -> None:
        rows.append(row)
        if len(rows) == at:
            do()

    coordinator = Coordinator(opened, Planner(opened, Counting(), Space()), engine, take)
    await asyncio.wait_for(coordinator.run(), 20.0)
    opened.close()
    return rows


async def test_each_engine_takes_as_many_chunks_as_it_has_slots(tmp_path: Path) -> None:
    first, second = Machine("first", 1), Machine("second", 2)
    rows = await carry_out(tmp_path, Engines([first, second]), 2000)
    assert sorted(row.run for row in rows) == list(range(1, 2001))
    assert (first.most, second.most) == (1, 2)
    assert {row.worker for row in rows} == {"first", "second"}


async def test_engines_for_one_robot_take_one_chunk_at_a_time(tmp_path: Path) -> None:
    first, second = Machine("first", 1), Machine("second", 2)
    engines = Engines([first, second], most=1)
    assert engines.slots == 1
    await carry_out(tmp_path, engines, 20)
    assert (first.most, second.most) == (1, 0)


async def test_slots_that_appear_are_used_and_lost_ones_are_not(tmp_path: Path) -> None:
    first, second = Machine("first", 1), Machine("second", 0)

    def change() -> None:
        first.set(0)
        second.set(2)

    rows = await carry_out(tmp_path, Engines([first, second]), 1000, at=20, do=change)
    assert sorted(row.run for row in rows) == list(range(1, 1001))
    assert second.most == 2 and {row.worker for row in rows[300:]} == {"second"}


async def test_a_campaign_waits_for_a_machine_and_is_stopped_meanwhile(tmp_path: Path) -> None:
    opened = campaign(tmp_path, runs=5)
    coordinator = Coordinator(opened, Planner(opened, Counting(), Space()), Machine("none", 0), lambda row: None)
    running = asyncio.create_task(coordinator.run())
    for _ in range(10):
        await asyncio.sleep(0)
    assert not running.done()
    coordinator.stop()
    await asyncio.wait_for(running, 20.0)
    opened.close()


@pytest.mark.parametrize(
    ("loss", "attempts"), [(MachineLost, ATTEMPTS_IF_LOST), (Killed, ATTEMPTS_IF_LOST), (WorkerDied, ATTEMPTS)]
)
async def test_lost_runs_are_made_again(loss: type[WorkerDied], attempts: int, tmp_path: Path) -> None:
    machine = Machine("weak", 1)
    machine.loss, machine.lost_chunks = loss, attempts - 1
    rows = await carry_out(tmp_path, Engines([machine]), 1)
    assert [(row.run, row.status) for row in rows] == [(1, End.PASSED)]


@pytest.mark.parametrize(("loss", "attempts"), [(Killed, ATTEMPTS_IF_LOST), (WorkerDied, ATTEMPTS)])
async def test_a_run_that_is_lost_each_time_is_an_error(
    loss: type[WorkerDied], attempts: int, tmp_path: Path
) -> None:
    machine = Machine("weak", 1)
    machine.loss, machine.lost_chunks = loss, attempts
    rows = await carry_out(tmp_path, Engines([machine]), 3)
    assert sorted((row.run, row.status, row.reason) for row in rows if row.run == 1) == [
        (1, End.ERROR, "weak is lost")
    ]
    assert len(rows) == 3
