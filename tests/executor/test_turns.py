"""Whose turn it is: of those who have robots, those who have not begun, and those who may have no more."""

from __future__ import annotations

import asyncio

import anyio

from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.messages import RunInfo, State
from seoro.changes import Changes
from seoro.executor.limits import Limits, Policy
from seoro.executor.live import LiveRun
from seoro.executor.turns import Turns
from seoro.executor.watching import Pace

DEADLINE = 5.0  # [s]
RUN = "0" * 32


def run_of(by: str, priority: int = 0) -> LiveRun:
    """A run that may wait for robots."""
    options = wire.BundledOptions(overrides={}, grace=5.0, leasing=wire.BundledLeasing(wait=60.0))
    file = wire.BundleFile(path="a.osc", hash="0" * 64, size=0)
    manifest = wire.Manifest(files=(file,), entry="a.osc", shown="a.osc", options=options)
    info = RunInfo(run=RUN, file="a.osc", by=by, state=State.QUEUED, submitted=0.0, priority=priority)
    return LiveRun(info, wire.Submission(run=RUN, manifest=manifest, by=by), Pace())


def turns_of(jobs: int, **limits: object) -> Turns:
    return Turns(jobs, Policy(everybody=Limits.model_validate(limits)), Changes())


async def returning(turns: Turns, live: LiveRun) -> asyncio.Task[None]:
    """A run that has waited, has its robots now, and waits for its turn."""
    turns.take(live)
    assert turns.lend(live)
    task = asyncio.create_task(turns.take_again(live))
    await asyncio.sleep(0)
    return task


async def has_turn(task: asyncio.Task[None]) -> None:
    with anyio.fail_after(DEADLINE):
        await task


async def test_those_who_have_robots_go_before_those_who_have_not_begun_and_the_urgent_first() -> None:
    turns = turns_of(1)
    other, usual, urgent, new = run_of("a"), run_of("b"), run_of("c", priority=5), run_of("d")
    turns.take(other)
    first, second = [await returning(turns, each) for each in (usual, urgent)]
    assert not turns.is_free_for(new)
    turns.end(other)
    await has_turn(second)
    assert not first.done()
    assert not turns.is_free_for(new)
    turns.end(urgent)
    await has_turn(first)
    turns.end(usual)
    assert turns.is_free_for(new)


async def test_one_who_may_have_no_more_holds_nobody_up() -> None:
    turns = turns_of(2, running=1)
    first, second, other = run_of("a"), run_of("a"), run_of("b")
    turns.take(first)
    task = await returning(turns, second)
    assert not task.done()
    assert turns.is_free_for(other)
    turns.end(first)
    await has_turn(task)
    assert (turns.taken, list(turns.lent)) == (1, [])


async def test_one_that_is_stopped_gets_no_turn_and_keeps_none_from_others() -> None:
    turns = turns_of(1)
    other, stopped, new = run_of("a"), run_of("b"), run_of("c")
    turns.take(other)
    task = await returning(turns, stopped)
    stopped.stop("the test says so")
    turns.end(other)
    await asyncio.sleep(0)
    assert not task.done()
    assert turns.is_free_for(new)
    task.cancel()
    turns.end(stopped)
    assert list(turns.lent) == []
