"""Order in which runs with robots, new runs, and runs of clients at their limit get slots."""

from __future__ import annotations

import asyncio

import anyio

from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.messages import RunInfo, State
from seoro.concurrency.condition import Condition
from seoro.executor.limits import Limits, Policy
from seoro.executor.runs.active_run import ActiveRun
from seoro.executor.runs.run_slots import RunSlots
from seoro.executor.runs.tail import Pace

DEADLINE = 30.0  # [s]
RUN = "0" * 32


def run_of(by: str, priority: int = 0) -> ActiveRun:
    """Return a run that may wait for robots."""
    options = wire.BundledOptions(overrides={}, grace=5.0, leasing=wire.BundledLeasing(wait=60.0))
    file = wire.BundleFile(path="a.osc", hash="0" * 64, size=0)
    manifest = wire.Manifest(files=(file,), entry="a.osc", shown="a.osc", options=options)
    info = RunInfo(run=RUN, file="a.osc", by=by, state=State.QUEUED, submitted=0.0, priority=priority)
    return ActiveRun(info, wire.Submission(run=RUN, manifest=manifest, by=by), Pace())


def turns_of(jobs: int, **limits: object) -> RunSlots:
    return RunSlots(jobs, Policy(everybody=Limits.model_validate(limits)), Condition())


async def returning(slots: RunSlots, live: ActiveRun) -> asyncio.Task[None]:
    """Return a task of a run with robots that waits for its slot."""
    slots.acquire(live)
    assert slots.lend(live)
    task = asyncio.create_task(slots.acquire_again(live))
    await asyncio.sleep(0)
    return task


async def has_turn(task: asyncio.Task[None]) -> None:
    with anyio.fail_after(DEADLINE):
        await task


async def test_runs_with_robots_precede_new_runs_by_priority() -> None:
    slots = turns_of(1)
    other, usual, urgent, new = run_of("a"), run_of("b"), run_of("c", priority=5), run_of("d")
    slots.acquire(other)
    first, second = [await returning(slots, each) for each in (usual, urgent)]
    assert not slots.is_free_for(new)
    slots.release(other)
    await has_turn(second)
    assert not first.done()
    assert not slots.is_free_for(new)
    slots.release(urgent)
    await has_turn(first)
    slots.release(usual)
    assert slots.is_free_for(new)


async def test_a_user_at_the_limit_delays_no_other() -> None:
    slots = turns_of(2, running=1)
    first, second, other = run_of("a"), run_of("a"), run_of("b")
    slots.acquire(first)
    task = await returning(slots, second)
    assert not task.done()
    assert slots.is_free_for(other)
    slots.release(first)
    await has_turn(task)
    assert (slots.taken, list(slots.lent)) == (1, [])


async def test_a_stopped_run_takes_no_slot() -> None:
    slots = turns_of(1)
    other, stopped, new = run_of("a"), run_of("b"), run_of("c")
    slots.acquire(other)
    task = await returning(slots, stopped)
    stopped.stop("set by the test")
    slots.release(other)
    await asyncio.sleep(0)
    assert not task.done()
    assert slots.is_free_for(new)
    task.cancel()
    slots.release(stopped)
    assert list(slots.lent) == []
