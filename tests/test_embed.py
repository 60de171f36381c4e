"""Running scenarios from Python, as the documentation shows it."""

import asyncio
import signal
import threading
from pathlib import Path
from typing import get_type_hints

import pytest

import seoro
from seoro.embed import OptionFields, Options

TEXT = """import osc.helpers
import osc.types

scenario greet:
    name: string = "world"
    do serial:
        log("hello " + name)
        wait elapsed(1h)
        log("bye")
"""


@pytest.fixture
def scenario(tmp_path: Path) -> seoro.Scenario:
    (tmp_path / "greet.osc").write_text(TEXT)
    return seoro.load(tmp_path / "greet.osc")


def test_the_keyword_arguments_of_start_are_the_options() -> None:
    assert get_type_hints(OptionFields) == get_type_hints(Options)


async def test_a_run_in_the_callers_loop(scenario: seoro.Scenario) -> None:
    async with seoro.start(scenario, seed=7, clock="virtual", overrides={"name": '"Ada"'}) as run:
        messages = [record["message"] async for record in run.trace() if record["kind"] == "log"]
    verdict = await run.result()
    assert messages == ["hello Ada", "bye"]
    assert verdict.passed
    assert (verdict.seed, verdict.duration) == (7, 3600.0)
    assert run.parameters == {"name": "Ada"}


async def test_many_runs_at_once(scenario: seoro.Scenario) -> None:
    async def one(seed: int) -> seoro.Verdict:
        async with seoro.start(scenario, seed=seed, clock="virtual") as run:
            return await run.result()

    verdicts = await asyncio.gather(*(one(seed) for seed in range(20)))
    assert [verdict.seed for verdict in verdicts] == list(range(20))
    assert all(verdict.passed for verdict in verdicts)


async def test_nothing_of_the_program_is_touched(scenario: seoro.Scenario) -> None:
    handlers = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    before, threads = asyncio.all_tasks(), threading.active_count()
    async with seoro.start(scenario, clock="virtual") as run:
        await run.result()
        assert [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)] == handlers
    assert asyncio.all_tasks() == before
    assert threading.active_count() == threads


async def test_an_exception_of_the_block_comes_out_as_it_is(scenario: seoro.Scenario) -> None:
    with pytest.raises(KeyError):
        async with seoro.start(scenario, clock="real"):
            raise KeyError("mine")


async def test_a_simulator_that_is_not_there_is_told_plainly(scenario: seoro.Scenario) -> None:
    with pytest.raises(seoro.InvalidUse, match="there is no simulator 'gazebo'"):
        async with seoro.start(scenario, simulator=seoro.Simulator(name="gazebo")):
            pass


def test_errors_of_the_text_come_all_at_once(tmp_path: Path) -> None:
    (tmp_path / "bad.osc").write_text("scenario main:\n    do serial:\n        one()\n        two()\n")
    with pytest.raises(seoro.InvalidScenario) as caught:
        seoro.load(tmp_path / "bad.osc")
    assert len(caught.value.diagnostics) == 2
    assert "bad.osc:3:9" in str(caught.value)
    assert "bad.osc:4:9" in str(caught.value)
