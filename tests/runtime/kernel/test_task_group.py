"""`TaskGroup` alone: it joins its children on every path, and asks its policy."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from functools import partial

import pytest

from seoro.runtime.kernel.cancel_scope import CancelScope
from seoro.runtime.kernel.task import Task
from seoro.runtime.kernel.task_group import TaskGroup
from tests.runtime.kernel.runs import other_tasks, run


class Recorder:
    """A policy that records the calls, and holds guarded children."""

    group: TaskGroup

    def __init__(self) -> None:
        self.calls: list[tuple[str, object, float]] = []
        self.held: list[Callable[[], None]] = []

    def child_ready(self, child: Task, resume: Callable[[], None]) -> None:
        self.calls.append(("ready", child.path, self.group.now))
        self.held.append(resume)

    def child_ended(self, child: Task) -> None:
        self.calls.append(("ended", child.outcome, self.group.now))


async def sleep(task: Task, duration: float, outcome: str = "") -> str:
    await task.sleep(duration)
    return outcome


async def clean_up(task: Task, log: list[str], name: str) -> None:
    """Sleep; a cancellation is followed by a clean-up of 1 s."""
    try:
        await task.sleep_forever()
    finally:
        await task.sleep(1.0)
        log.append(f"{name} {task.scheduler.now:g}")


# -------------------------------------------------------- joining


async def test_leaving_the_block_joins_the_children() -> None:
    async def main(task: Task) -> list[object]:
        before = other_tasks()
        async with TaskGroup(task) as group:
            children = [group.start_soon(sleep, duration) for duration in (2.0, 1.0)]
            await task.sleep(0.5)
            during = len(other_tasks() - before)
        return [during, task.scheduler.now, [child.alive for child in children], other_tasks() - before]

    assert (await run(main)).outcome == [2, 2.0, [False, False], set()]


async def test_children_are_done_for_asyncio_too_when_the_block_is_left() -> None:
    async def main(task: Task) -> bool:
        async with TaskGroup(task) as group:
            children = [group.start_soon(sleep, 1.0) for _ in range(3)]
        handles = [child.handle for child in children]
        return all(handle is not None and handle.done() for handle in handles)

    assert (await run(main)).outcome is True


async def test_a_block_that_raises_cancels_the_children_and_joins_them() -> None:
    log: list[str] = []

    async def main(task: Task) -> list[object]:
        with pytest.raises(KeyError):
            async with TaskGroup(task) as group:
                group.start_soon(clean_up, log, "first")
                group.start_soon(clean_up, log, "second")
                await task.sleep(1.0)
                raise KeyError("of the block")
        return [task.scheduler.now, group.has_ended]

    assert (await run(main)).outcome == [2.0, True]
    assert sorted(log) == ["first 2", "second 2"]


async def test_a_block_that_is_cancelled_joins_the_children() -> None:
    log: list[str] = []

    async def main(task: Task) -> list[object]:
        with CancelScope(task) as scope:
            async with TaskGroup(task) as group:
                group.start_soon(clean_up, log, "first")
                group.start_soon(clean_up, log, "second")
                await task.sleep(1.0)
                scope.cancel_at_commit((), "cancelled")
                await task.sleep_forever()
        return [task.scheduler.now, group.has_ended, scope.outcome]

    assert (await run(main)).outcome == [3.0, True, "cancelled"]
    assert log == ["second 2", "first 3"]


async def test_a_parent_that_is_cancelled_while_it_joins_still_joins() -> None:
    log: list[str] = []

    async def parent(task: Task) -> None:
        async with TaskGroup(task) as group:
            group.start_soon(clean_up, log, "child")
        raise AssertionError("the block swallowed a cancellation")

    async def main(task: Task) -> None:
        async with TaskGroup(task) as group:
            child = group.start_soon(parent)
            await task.sleep(1.0)
            group.cancel(child)
        log.append(f"joined {task.scheduler.now:g}")

    await run(main)
    assert log == ["child 2", "joined 2"]


async def test_a_child_that_raises_is_a_defect_and_the_rest_is_joined() -> None:
    defects: list[Exception] = []

    async def fail(task: Task) -> None:
        raise KeyError("of the child")

    async def main(task: Task) -> list[object]:
        async with TaskGroup(task) as group:
            failing = group.start_soon(fail)
            other = group.start_soon(sleep, 1.0, "slept")
        return [failing.outcome, other.outcome, task.scheduler.now]

    assert (await run(main, defect=defects.append)).outcome == [None, "slept", 1.0]
    assert [type(error) for error in defects] == [KeyError]


async def test_a_child_that_awaits_the_loop_is_cancelled_with_the_program() -> None:
    async def main(task: Task) -> None:
        async with TaskGroup(task) as group:
            group.start_soon(Task.sleep_forever)
            asyncio.get_running_loop().call_soon(awaiting.cancel)
            await task.sleep_forever()

    awaiting = asyncio.ensure_future(run(main))
    with pytest.raises(asyncio.CancelledError):
        await awaiting
    assert other_tasks() == set()


async def test_a_block_without_children_ends_at_once() -> None:
    async def main(task: Task) -> bool:
        async with TaskGroup(task) as group:
            pass
        return group.has_ended

    assert (await run(main)).outcome is True


async def test_the_parent_may_join_within_the_block_and_start_more() -> None:
    async def main(task: Task) -> list[float]:
        times = []
        async with TaskGroup(task) as group:
            for _ in range(2):
                group.start_soon(sleep, 1.0)
                await group.join()
                times.append(group.now)
        return times

    assert (await run(main)).outcome == [1.0, 2.0]


# -------------------------------------------------------- policies


async def test_a_policy_receives_the_ends_of_children() -> None:
    policy = Recorder()

    async def main(task: Task) -> None:
        async with TaskGroup(task, policy) as group:
            policy.group = group
            group.start_soon(sleep, 2.0, "late")
            group.start_soon(sleep, 1.0, "early")
            group.cancel(group.start_soon(sleep, 3.0, "never"))

    await run(main)
    assert policy.calls == [("ended", None, 0.0), ("ended", "early", 1.0), ("ended", "late", 2.0)]


async def test_a_guarded_child_continues_when_the_policy_resumes_it() -> None:
    policy, log = Recorder(), []

    async def wait_twice(task: Task) -> None:
        await task.sleep(1.0)
        log.append(task.scheduler.now)
        await task.sleep(1.0)
        log.append(task.scheduler.now)

    async def main(task: Task) -> None:
        async with TaskGroup(task, policy) as group:
            policy.group = group
            group.start_soon(wait_twice, guarded=True)
            await task.sleep(5.0)
            policy.held[0]()

    await run(main)
    assert policy.calls == [("ready", (0,), 1.0), ("ended", None, 6.0)]
    assert log == [5.0, 6.0]


async def test_a_guarded_child_that_is_held_can_be_cancelled() -> None:
    policy = Recorder()

    async def main(task: Task) -> None:
        async with TaskGroup(task, policy) as group:
            policy.group = group
            group.start_soon(sleep, 1.0, "slept", guarded=True)
            group.after(2.0, group.cancel_all)

    await run(main)
    assert policy.calls == [("ready", (0,), 1.0), ("ended", None, 2.0)]


async def test_a_wait_for_a_time_ends_early_when_it_is_interrupted() -> None:
    async def main(task: Task) -> list[float]:
        times = []
        async with TaskGroup(task) as group:
            await group.wait_until(1.0)
            times.append(group.now)
            group.after(1.0, group.interrupt)
            for _ in range(2):
                await group.wait_until(10.0)
                times.append(group.now)
        return times

    assert (await run(main)).outcome == [1.0, 2.0, 2.0]


async def test_the_ends_of_children_do_not_end_a_wait_for_a_time() -> None:
    async def main(task: Task) -> float:
        async with TaskGroup(task) as group:
            group.start_soon(sleep, 1.0)
            await group.wait_until(2.0)
        return group.now

    assert (await run(main)).outcome == 2.0


async def test_deferred_calls_are_dropped_after_the_block() -> None:
    log: list[str] = []

    async def main(task: Task) -> None:
        async with TaskGroup(task) as group:
            group.after(1.0, partial(log.append, "within"))
            group.after(3.0, partial(log.append, "after"))
            await task.sleep(2.0)
        await task.sleep(5.0)

    await run(main)
    assert log == ["within"]


async def test_a_choice_is_made_after_the_instant_has_settled_and_before_deadlines() -> None:
    log: list[str] = []

    async def main(task: Task) -> None:
        async with TaskGroup(task) as group:
            group.after(0.0, partial(log.append, "due"))
            group.choose(partial(log.append, "choice"))
            for _ in range(3):
                await task.step()
            log.append("steps")

            await task.sleep(1.0)

    await run(main)
    assert log == ["steps", "choice", "due"]


async def test_a_child_is_ended_with_an_outcome_in_the_scope_that_it_has_opened() -> None:
    async def child(task: Task) -> object:
        with CancelScope(task) as outermost:
            with CancelScope(task) as inner:
                await task.sleep_forever()
            raise AssertionError("the outermost one is ended")
        return [outermost.outcome, inner.outcome]

    async def main(task: Task) -> object:
        async with TaskGroup(task) as group:
            in_scopes = group.start_soon(child)
            without = group.start_soon(sleep, 10.0, "slept")
            group.after(1.0, partial(group.end, in_scopes, "enough"))
            group.after(1.0, partial(group.end, without, "enough"))
        return [in_scopes.outcome, without.outcome, group.now]

    assert (await run(main)).outcome == [["enough", None], None, 1.0]
