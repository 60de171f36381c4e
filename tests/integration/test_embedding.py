"""Runs of one program with their own simulators."""

import asyncio
import tempfile
from collections import Counter
from contextlib import suppress
from pathlib import Path

import pytest

import seoro
from tests.embedding.conftest import Records, holdings, left_of_simulations, without_stamps
from tests.integration.conftest import GO_TO_POSE

SIMULATOR = seoro.Simulator(name="mujoco")


async def trace_of(scenario: seoro.Scenario, seed: int) -> Records:
    async with seoro.start(scenario, seed=seed, simulator=SIMULATOR) as run:
        return without_stamps([record async for record in run.trace()])


def folders() -> set[Path]:
    """Return the folders of runs among temporary files."""
    return set(Path(tempfile.gettempdir()).glob("seoro-*"))


@pytest.mark.more
async def test_simultaneous_runs_have_the_traces_of_single_runs() -> None:
    scenario = seoro.load(GO_TO_POSE)
    at_once = await asyncio.gather(*(trace_of(scenario, seed) for seed in (1, 2)))
    assert at_once == [await trace_of(scenario, seed) for seed in (1, 2)]
    assert [records[-1]["status"] for records in at_once] == ["passed", "passed"]


@pytest.mark.more
async def test_a_cancelled_run_leaves_no_files_and_processes() -> None:
    scenario = seoro.load(GO_TO_POSE)
    await trace_of(scenario, 1)  # Zenoh keeps some files for the process
    held: Counter[str] = holdings()
    mine = folders()
    for delay in (0.0, 0.01, 0.05, 0.2, 0.5, 1.0, 2.0):
        task = asyncio.create_task(trace_of(scenario, 2))
        await asyncio.sleep(delay)
        task.cancel()
        with suppress(asyncio.CancelledError):
            await task
        assert not await left_of_simulations(held), f"after {delay} s"
        assert not folders() - mine, f"after {delay} s"
