"""`Task` alone: its steps, sleeps, past, outcome and descendants."""

from __future__ import annotations

from functools import partial

from seoro.runtime.kernel.cancel_scope import CancelScope
from seoro.runtime.kernel.task import Task
from seoro.runtime.kernel.task_group import TaskGroup
from tests.runtime.kernel.runs import run, scheduler_of


async def double(task: Task, number: int) -> int:
    await task.step()
    return 2 * number


async def test_the_outcome_is_the_result_of_the_function() -> None:
    root = await run(double, 21)
    assert (root.outcome, root.alive, root.path) == (42, False, ())


async def test_a_step_yields_to_other_tasks() -> None:
    log: list[str] = []

    async def child(task: Task, name: str) -> None:
        await task.step()  # begins the first one
        for number in range(2):
            log.append(f"{name}{number}")
            await task.step()

    async def main(task: Task) -> None:
        async with TaskGroup(task) as group:
            group.start_soon(child, "a")
            group.start_soon(child, "b")

    await run(main)
    assert log == ["a0", "b0", "a1", "b1"]


async def test_a_task_sleeps_for_a_time_and_until_a_time() -> None:
    async def main(task: Task) -> list[float]:
        times = []
        for sleep in (partial(task.sleep, 1.5), partial(task.sleep_until, 4.0), partial(task.sleep_until, 2.0)):
            await sleep()
            times.append(task.scheduler.now)
        return times

    assert (await run(main)).outcome == [1.5, 4.0, 4.0]


async def test_a_tenth_and_two_tenths_are_due_with_three_tenths() -> None:
    instants: list[int] = []

    async def child(task: Task, *durations: float) -> None:
        for duration in durations:
            await task.sleep(duration)
        instants.append(scheduler_of(task).instant)

    async def main(task: Task) -> None:
        async with TaskGroup(task) as group:
            group.start_soon(child, 0.1, 0.2)
            group.start_soon(child, 0.3)

    await run(main)
    assert instants == [2, 2]


async def test_a_task_sleeps_until_it_is_cancelled() -> None:
    async def main(task: Task) -> str:
        with CancelScope(task) as scope:
            scope.cancel_at_commit((), "enough")
            await task.sleep_forever()
        return str(scope.outcome)

    assert (await run(main)).outcome == "enough"


async def test_a_task_begins_with_the_past_of_the_one_that_starts_it() -> None:
    async def child(task: Task) -> bool:
        known = task.past.contains(1, 0)
        task.past.add(2, 0)
        return known

    async def main(task: Task) -> list[bool]:
        task.past.add(1, 0)
        async with TaskGroup(task) as group:
            started = group.start_soon(child)
            await task.sleep(0.0)
            before = task.past.contains(2, 0)
        return [started.outcome, before, task.past.contains(2, 0)]

    assert (await run(main)).outcome == [True, False, True]


async def test_the_end_of_a_task_is_reported_once_it_has_ended() -> None:
    ended: list[object] = []

    async def main(task: Task) -> None:
        async with TaskGroup(task) as group:
            child = group.start_soon(double, 1)
            child.when_ended(lambda child: ended.append((child.alive, child.outcome)))

    await run(main)
    assert ended == [(False, 2)]


async def test_descendants_are_in_the_order_of_starts() -> None:
    found: list[tuple[int, ...]] = []

    async def hold(task: Task, children: int) -> None:
        async with TaskGroup(task) as group:
            for _ in range(children):
                group.start_soon(hold, 0)
            await task.sleep(1.0)

    async def main(task: Task) -> None:
        async with TaskGroup(task) as group:
            for index in (1, 0):
                group.start_soon(hold, 2, path=(index,))
            await task.sleep(0.5)
            found.extend(each.path for each in task.descendants())
        assert task.descendants() == []

    await run(main)
    assert found == [(0,), (1,), (0, 0), (0, 1), (1, 0), (1, 1)]


async def test_descendants_of_a_scope_were_started_in_it() -> None:
    async def main(task: Task) -> list[tuple[int, ...]]:
        async with TaskGroup(task) as around:
            around.start_soon(Task.sleep, 1.0, path=(0,))
            with CancelScope(task) as scope:
                async with TaskGroup(task) as inside:
                    inside.start_soon(Task.sleep, 1.0, path=(1,))
                    found = [each.path for each in scope.tasks]
        return found

    assert (await run(main)).outcome == [(1,)]
