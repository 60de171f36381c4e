"""Several runs in one process do not affect each other."""

import asyncio
import math
import subprocess
import sys
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
import uvloop

import seoro
from seoro.runtime.execution import blocking
from tests.embedding.conftest import Records, without_stamps

SEEDS = range(50)


@pytest.fixture(autouse=True)
def _no_word_of_blocking(monkeypatch: pytest.MonkeyPatch) -> None:
    """Switch off warnings about slow steps: they depend on the load, and would be in the traces."""
    monkeypatch.setattr(blocking, "LIMIT", math.inf)


async def trace_of(scenario: seoro.Scenario, seed: int) -> Records:
    """The trace of a run."""
    async with seoro.start(scenario, seed=seed, clock="virtual") as run:
        return without_stamps([record async for record in run.trace()])


async def all_at_once(scenario: seoro.Scenario) -> list[Records]:
    """The traces of runs with different seeds, in one loop."""
    return await asyncio.gather(*(trace_of(scenario, seed) for seed in SEEDS))


@pytest.fixture
def alone(scenario: seoro.Scenario) -> list[Records]:
    """The same traces, of runs of which each has a loop of its own."""
    return [asyncio.run(trace_of(scenario, seed)) for seed in SEEDS]


@pytest.mark.more
def test_fifty_simultaneous_runs_have_the_same_traces_as_sequential_ones(
    scenario: seoro.Scenario, alone: list[Records]
) -> None:
    at_once = asyncio.run(all_at_once(scenario))
    assert at_once == alone
    assert len({str(records) for records in at_once}) > 1
    assert {records[-1]["status"] for records in at_once} == {"passed"}


@pytest.mark.more
def test_uvloop_gives_the_same_traces(scenario: seoro.Scenario, alone: list[Records]) -> None:
    with asyncio.Runner(loop_factory=uvloop.new_event_loop) as runner:
        assert runner.run(all_at_once(scenario)) == alone


def test_runs_in_the_loops_of_threads_have_the_traces_that_they_have_alone(
    scenario: seoro.Scenario, alone: list[Records]
) -> None:
    found: dict[int, Records] = {}

    def run(seed: int) -> None:
        found[seed] = asyncio.run(trace_of(scenario, seed))

    threads = [threading.Thread(target=run, args=(seed,)) for seed in SEEDS[:6]]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [found[seed] for seed in SEEDS[:6]] == alone[:6]


@pytest.mark.skipif(sys.version_info < (3, 12), reason="this Python starts no tasks eagerly")
async def test_a_loop_that_starts_tasks_eagerly_loses_no_record(scenario: seoro.Scenario) -> None:
    expected = await trace_of(scenario, 1)
    asyncio.get_running_loop().set_task_factory(getattr(asyncio, "eager_task_factory"))  # noqa: B009
    assert await trace_of(scenario, 1) == expected


def test_threads_load_a_scenario_simultaneously(tmp_path: Path) -> None:
    """The first thread imports the Python module of its library."""
    folder = tmp_path / "seoro.libraries"
    folder.mkdir()
    (folder / "garden.osc").write_text("action water\n")
    (folder / "garden.py").write_text(
        "import time\ntime.sleep(0.05)\nfrom seoro import ActionContext, action\n"
        '@action("water")\nasync def water(ctx: ActionContext) -> None:\n    ctx.log("wet")\n'
    )
    (tmp_path / "main.osc").write_text("import osc.ros\nimport osc.garden\nscenario main:\n    do water()\n")
    with ThreadPoolExecutor(8) as pool:
        loaded = list(pool.map(seoro.load, [tmp_path / "main.osc"] * 16))
        assert all(pool.map(lambda scenario: seoro.run(scenario, clock="virtual").passed, loaded))


async def test_runs_of_one_scenario_share_no_state(load: Callable[[str], seoro.Scenario]) -> None:
    scenario = load(
        "import osc.types\nimport osc.helpers\n"
        "scenario main:\n    var count: int = 0\n    do serial:\n        increment(count)\n"
        '        wait elapsed([1s..5s])\n        increment(count)\n        log(count == 2 ? "two" : "many")\n'
    )
    traces = await asyncio.gather(*(trace_of(scenario, seed) for seed in range(10)))
    logs = [record["message"] for records in traces for record in records if record["kind"] == "log"]
    assert logs == ["two"] * 10


async def test_real_and_virtual_time_live_in_one_loop(load: Callable[[str], seoro.Scenario]) -> None:
    short = load("import osc.types\nscenario main:\n    do wait elapsed(0.05s)\n")

    async def run(clock: str) -> seoro.Verdict:
        async with seoro.start(short, clock=clock) as started:  # type: ignore[arg-type]
            return await started.result()

    real, virtual = await asyncio.gather(run("real"), run("virtual"))
    assert virtual.duration == 0.05 <= real.duration
    assert virtual.wall_duration < real.wall_duration


def test_a_script_needs_no_loop_of_its_own(scenario: seoro.Scenario) -> None:
    verdict = seoro.run(scenario, seed=7, clock="virtual")
    assert verdict.passed
    assert verdict.seed == 7


async def test_run_is_rejected_within_an_event_loop(scenario: seoro.Scenario) -> None:
    with pytest.raises(seoro.UsageError, match="cannot be called from a running event loop"):
        seoro.run(scenario)


def test_ctrl_c_stops_the_run_of_a_script_in_order(tmp_path: Path) -> None:
    (tmp_path / "main.osc").write_text("import osc.types\nscenario main:\n    do wait elapsed(1h)\n")
    script = (
        "import os, signal, threading, seoro\n"
        "class Watch:\n"
        "    def record(self, record):\n"
        "        print(record['kind'], record.get('status', ''))\n"
        "        if record.get('type') == 'wait' and record['kind'] == 'behavior.start':\n"
        "            os.kill(os.getpid(), signal.SIGINT)\n"
        "try:\n"
        "    seoro.run(seoro.load('main.osc'), observers=[Watch()])\n"
        "except KeyboardInterrupt:\n"
        "    print('interrupted')\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, timeout=30, check=True
    )
    assert done.stdout.splitlines()[-3:] == ["behavior.end cancelled", "run.end cancelled", "interrupted"]
    assert done.stderr == ""
