"""`CancelScope` alone: cancelled tasks, their order, and passing exceptions."""

from __future__ import annotations

import asyncio
from functools import partial

import pytest

from seoro.runtime.kernel.cancel_scope import CancelScope, cancel_task
from seoro.runtime.kernel.task import Task
from seoro.runtime.kernel.task_group import TaskGroup
from seoro.runtime.kernel.timers import Deadline
from tests.runtime.kernel.runs import outside, run, scheduler_of


def cancel_at(task: Task, time: float, scope: CancelScope, outcome: str) -> None:
    """Cancel a scope at a time, when that instant has otherwise settled."""
    scheduler_of(task).act_at(time, Deadline(scope, partial(scope.cancel, outcome)))


async def test_a_block_is_left_when_it_is_cancelled() -> None:
    async def main(task: Task) -> list[object]:
        with CancelScope(task) as scope:
            cancel_at(task, 1.0, scope, "late")
            await task.sleep(10.0)
        return [scope.outcome, scope.is_cancelled, task.scheduler.now]

    assert (await run(main)).outcome == ["late", False, 1.0]


async def test_the_first_given_outcome_counts() -> None:
    async def main(task: Task) -> object:
        with CancelScope(task) as scope:
            scope.cancel_at_commit((1,), "second")
            scope.cancel_at_commit((0,), "first")
            await task.sleep_forever()
        scope.cancel("third")
        return scope.outcome

    assert (await run(main)).outcome == "first"


async def test_a_block_that_ends_by_itself_has_no_outcome() -> None:
    async def main(task: Task) -> list[object]:
        with CancelScope(task) as scope:
            await task.sleep(1.0)
        scope.cancel_at_commit((), "too late")
        await task.sleep(1.0)
        return [scope.outcome, task.scheduler.now]

    assert (await run(main)).outcome == [None, 2.0]


async def test_tasks_are_cancelled_last_started_first_each_after_the_clean_up_of_the_one_before() -> None:
    log: list[str] = []

    async def hold(task: Task, name: str, children: int) -> None:
        try:
            async with TaskGroup(task) as group:
                for number in range(children):
                    group.start_soon(hold, f"{name}{number}", 0)
                await task.sleep_forever()
        finally:
            await task.sleep(1.0)
            log.append(f"{name} {task.scheduler.now:g}")

    async def main(task: Task) -> None:
        with CancelScope(task) as scope:
            cancel_at(task, 1.0, scope, "cancelled")
            async with TaskGroup(task) as group:
                group.start_soon(hold, "a", 1)
                group.start_soon(hold, "b", 2)
                try:
                    await task.sleep_forever()
                finally:
                    log.append(f"own {task.scheduler.now:g}")

    await run(main)
    assert log == ["b1 2", "b0 3", "a0 4", "b 5", "a 6", "own 6"]


async def test_a_clean_up_may_await_the_outside_world() -> None:
    async def main(task: Task) -> list[object]:
        log: list[object] = []
        with CancelScope(task) as scope:
            cancel_at(task, 1.0, scope, "cancelled")
            try:
                await task.sleep_forever()
            finally:
                await outside(task, asyncio.sleep(0.01))
                log.append(task.scheduler.now)
        return log

    assert (await run(main)).outcome == [1.0]


async def test_a_cancellation_arrives_once() -> None:
    async def main(task: Task) -> list[float]:
        times = []
        with CancelScope(task) as scope:
            cancel_at(task, 1.0, scope, "first")
            cancel_at(task, 2.0, scope, "second")
            try:
                await task.sleep_forever()
            finally:
                for _ in range(2):
                    await task.sleep(1.0)
                    times.append(task.scheduler.now)
        return times

    assert (await run(main)).outcome == [2.0, 3.0]


async def test_only_the_cancelled_one_of_nested_scopes_is_left() -> None:
    async def main(task: Task) -> list[object]:
        with CancelScope(task) as outer:
            with CancelScope(task) as inner:
                cancel_at(task, 1.0, inner, "inner")
                await task.sleep_forever()
            assert (inner.outcome, task.scheduler.now) == ("inner", 1.0)
            cancel_at(task, 2.0, outer, "outer")
            with CancelScope(task) as innermost:
                await task.sleep_forever()
            raise AssertionError("the outer one is cancelled")
        return [outer.outcome, innermost.outcome, task.scheduler.now]

    assert (await run(main)).outcome == ["outer", None, 2.0]


async def test_an_outer_cancellation_cancels_inner_scopes() -> None:
    async def main(task: Task) -> list[bool]:
        with CancelScope(task) as outer:
            outer.cancel_at_commit((), "outer")
            with CancelScope(task) as inner:
                try:
                    await task.sleep_forever()
                finally:
                    found = [scope.is_cancelled for scope in (outer, inner)]
                    found += [scope.is_cancelled_itself for scope in (outer, inner)]
        return found

    assert (await run(main)).outcome == [True, True, True, False]


async def test_an_outer_cancellation_during_a_clean_up_goes_before_the_inner_one() -> None:
    async def main(task: Task) -> list[object]:
        with CancelScope(task) as outer:
            cancel_at(task, 2.0, outer, "outer")
            with CancelScope(task) as inner:
                cancel_at(task, 1.0, inner, "inner")
                try:
                    await task.sleep_forever()
                finally:
                    await task.sleep(2.0)
            raise AssertionError("the outer one is cancelled")
        return [outer.outcome, inner.outcome, task.scheduler.now]

    assert (await run(main)).outcome == ["outer", "inner", 3.0]


async def test_an_effect_does_not_cancel_a_scope_cancelled_by_an_outer_one() -> None:
    async def main(task: Task) -> list[object]:
        with CancelScope(task) as outer, CancelScope(task) as inner:
            inner.cancel_at_commit((1,), "inner")
            outer.cancel_at_commit((0,), "outer")
            await task.sleep_forever()
        return [outer.outcome, inner.outcome]

    assert (await run(main)).outcome == ["outer", None]


@pytest.mark.parametrize("error", [KeyError, asyncio.CancelledError])
async def test_cancellations_of_other_scopes_pass_through(error: type[BaseException]) -> None:
    async def main(task: Task) -> None:
        with pytest.raises(error), CancelScope(task):
            raise error

    await run(main)


async def test_the_cancellation_of_a_whole_task_passes_through_its_scopes() -> None:
    async def child(task: Task) -> str:
        with CancelScope(task):
            await task.sleep_forever()
        raise AssertionError("the scope swallowed a cancellation")

    async def main(task: Task) -> list[object]:
        async with TaskGroup(task) as group:
            started = group.start_soon(child)
            group.after(1.0, partial(cancel_task, started))
        return [started.outcome, started.alive]

    assert (await run(main)).outcome == [None, False]


async def test_a_task_that_is_cancelled_before_it_has_begun_does_nothing() -> None:
    log: list[str] = []

    async def child(task: Task) -> None:
        log.append("begun")

    async def main(task: Task) -> bool:
        async with TaskGroup(task) as group:
            started = group.start_soon(child)
            group.cancel(started)
        return started.alive

    assert (await run(main)).outcome is False
    assert log == []


async def test_a_cancelled_task_takes_no_step_even_if_it_is_ready() -> None:
    log: list[str] = []

    async def child(task: Task) -> None:
        log.append("first")
        scheduler_of(task).at_commit((), partial(cancel_task, task))
        await task.sleep(0.0)
        log.append("second")

    async def main(task: Task) -> None:
        async with TaskGroup(task) as group:
            group.start_soon(child)

    await run(main)
    assert log == ["first"]


async def test_waiting_for_the_cancellation_ends_with_it() -> None:
    async def main(task: Task) -> float:
        with CancelScope(task) as scope:
            cancel_at(task, 3.0, scope, "end")
            await scope.wait_cancelled()
        return task.scheduler.now

    assert (await run(main)).outcome == 3.0
