"""Links between clients and executors that are cut, lose, delay and double what passes."""

from __future__ import annotations

import time
from pathlib import Path

import anyio
import pytest

import seoro
from tests.executors import HELLO, NAME, RunningExecutor, executor
from tests.faults.checks import DEADLINE, follow, measured
from tests.faults.conftest import Link, far_router, packet_link

TICKS = """import osc.helpers
scenario ticks:
    event tick
    on every(20ms):
        emit tick
    do serial:
        wait elapsed({seconds}s)
"""


def write(folder: Path, text: str) -> Path:
    path = folder / "test.osc"
    path.write_text(text)
    return path


@pytest.mark.parametrize("seconds", [1, *(pytest.param(each, marks=pytest.mark.slow) for each in (5, 30))])
async def test_a_cut_link_only_costs_time(link: Link, far: RunningExecutor, seconds: int, tmp_path: Path) -> None:
    noticed: list[float] = []
    async with seoro.Client(link.near) as client:
        run = await client.submit(NAME, write(tmp_path, TICKS.format(seconds=seconds + 2)))
        run.executor.on_silence = lambda reason: noticed.append(time.monotonic())

        async def cut() -> None:
            await anyio.sleep(0.5)
            link.have(cut=True)
            began = time.monotonic()
            await anyio.sleep(seconds)
            link.have()
            measured(f"cut for {seconds} s: noticed after {[round(each - began, 1) for each in noticed]} s")

        async with anyio.create_task_group() as tasks:
            tasks.start_soon(cut)
            records = await follow(run)
        with anyio.fail_after(DEADLINE):
            assert [each.id for each in await client.runs()] == [run.id]
    assert len(records) > 50 * (seconds + 1)


@pytest.mark.parametrize(
    "faults",
    [
        {"loss": 0.2},
        *(pytest.param(each, marks=pytest.mark.slow) for each in ({"delay": 0.2}, {"loss": 0.1, "delay": 0.05})),
    ],
    ids=str,
)
async def test_a_bad_link_only_costs_time(
    link: Link, far: RunningExecutor, faults: dict[str, float], tmp_path: Path
) -> None:
    file = write(tmp_path, TICKS.format(seconds=1))
    async with seoro.Client(link.near) as client:
        link.have(**faults)
        began = time.monotonic()
        run = await client.submit(NAME, file)
        submitted = time.monotonic() - began
        await follow(run)
        measured(f"{faults}: submitted in {submitted:.1f} s, over after {time.monotonic() - began:.1f} s")
        link.have()
        with anyio.fail_after(DEADLINE):
            assert [each.id for each in await client.runs()] == [run.id]


async def test_a_scenario_submitted_during_a_cut_runs_once(
    link: Link, far: RunningExecutor, tmp_path: Path
) -> None:
    file = write(tmp_path, HELLO)
    async with seoro.Client(link.near) as client:
        await follow(await client.submit(NAME, file))
        async with anyio.create_task_group() as tasks:

            async def flicker() -> None:
                for _ in range(4):
                    link.have(cut=True)
                    await anyio.sleep(0.4)
                    link.have()
                    await anyio.sleep(0.03)

            tasks.start_soon(flicker)
            with anyio.fail_after(DEADLINE):
                run = await client.submit(NAME, file)
        await follow(run)
        assert len(await client.runs()) == 2


@pytest.mark.more
async def test_repeated_packets_have_no_effect(tmp_path: Path) -> None:
    with packet_link() as link, far_router(link), executor(tmp_path, connect=link.far, prefix=link.prefix):
        async with seoro.Client(link.near) as client:
            link.have(duplicate=0.5)
            run = await client.submit(NAME, write(tmp_path, TICKS.format(seconds=1)))
            await follow(run)
            assert [each.id for each in await client.runs()] == [run.id]
