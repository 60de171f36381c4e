"""`Scheduler` alone: instants, delta cycles, the order of steps and effects, and ends of runs."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from functools import partial

import pytest

from seoro.runtime.kernel.advance import Stuck
from seoro.runtime.kernel.cancel_scope import CancelScope
from seoro.runtime.kernel.clock import RealClock, VirtualClock
from seoro.runtime.kernel.delta import StepOrder
from seoro.runtime.kernel.scheduler import Scheduler
from seoro.runtime.kernel.task import Task, Waiter
from seoro.runtime.kernel.task_group import TaskGroup
from seoro.runtime.kernel.timers import Deadline, Timer
from tests.runtime.kernel.runs import LIMIT, other_tasks, outside, run, scheduler_of


async def end_at_once(task: Task) -> None:
    pass


# -------------------------------------------------------- instants and delta cycles


async def test_an_instant_is_at_the_time_at_which_something_is_due() -> None:
    seen: list[tuple[float, int]] = []

    async def main(task: Task) -> None:
        scheduler = scheduler_of(task)
        for duration in (0.0, 1.0, 0.0, 1.5):
            await task.sleep(duration)
            seen.append((scheduler.now, scheduler.instant))

    await run(main)
    assert seen == [(0.0, 0), (1.0, 1), (1.0, 1), (2.5, 2)]


async def test_a_step_is_a_delta_cycle_of_the_same_instant() -> None:
    async def main(task: Task) -> list[tuple[int, int]]:
        scheduler = scheduler_of(task)
        await task.sleep(0.0)
        first = scheduler.cycle
        await task.step()
        await task.step()
        return [(scheduler.instant, scheduler.cycle - first)]

    assert (await run(main)).outcome == [(0, 2)]


async def test_the_first_step_is_the_one_that_a_task_begins_with() -> None:
    async def main(task: Task) -> int:
        first = scheduler_of(task).cycle
        await task.step()
        return scheduler_of(task).cycle - first

    assert (await run(main)).outcome == 0


@pytest.mark.parametrize(
    ("step_order", "expected"),
    [(None, "abcabc"), (lambda path: tuple(-index for index in path), "cbacba")],
    ids=["by paths", "backwards"],
)
async def test_steps_of_a_cycle_have_an_order(step_order: StepOrder | None, expected: str) -> None:
    log: list[str] = []

    async def child(task: Task, name: str) -> None:
        log.append(name)
        await task.sleep(1.0)
        log.append(name)

    async def main(task: Task) -> None:
        async with TaskGroup(task) as group:
            for index, name in ((2, "c"), (0, "a"), (1, "b")):
                group.start_soon(child, name, path=(index,))

    await run(main, step_order=step_order)
    assert "".join(log) == expected


async def test_an_effect_is_not_visible_in_its_own_cycle() -> None:
    value, seen = [0], []

    async def write(task: Task) -> None:
        scheduler_of(task).write(task.path, partial(value.__setitem__, 0, 1))
        seen.append(value[0])

    async def read(task: Task) -> None:
        seen.append(value[0])
        await task.sleep(0.0)
        seen.append(value[0])

    async def main(task: Task) -> None:
        async with TaskGroup(task) as group:
            group.start_soon(write)
            group.start_soon(read)

    await run(main)
    assert seen == [0, 0, 1]


# -------------------------------------------------------- the order of effects


async def test_effects_are_committed_by_kind_then_in_their_order() -> None:
    log: list[str] = []

    async def main(task: Task) -> None:
        scheduler = scheduler_of(task)
        scheduler.after_sends(partial(log.append, "closing"))
        for index in (1, 0):
            scheduler.send(("channel", str(index)), partial(log.append, f"send {index}"))
            scheduler.at_commit((index,), partial(log.append, f"cancel {index}"))
            scheduler.check((index,), partial(log.append, f"check {index}"))
            scheduler.write((index,), partial(log.append, f"write {index}"))
        await task.sleep(0.0)

    await run(main)
    pairs = [f"{kind} {index}" for kind in ("write", "check", "cancel", "send") for index in (0, 1)]
    assert log == [*pairs, "closing"]


async def test_a_step_without_a_task_is_ordered_by_path() -> None:
    log: list[str] = []

    async def main(task: Task) -> None:
        scheduler_of(task).react((1,), partial(log.append, "after"))
        scheduler_of(task).react((), partial(log.append, "before"))
        await task.sleep(0.0)

    await run(main)
    assert log == ["before", "after"]


# -------------------------------------------------------- the end of an instant


def acts_at_end(scheduler: Scheduler, scope: CancelScope, act: Callable[[], None]) -> Deadline:
    deadline = Deadline(scope, act)
    scheduler.act_at(scheduler.now, deadline)
    return deadline


async def test_choices_are_made_before_deadlines_act_and_the_rest_follows() -> None:
    log: list[str] = []

    async def main(task: Task) -> None:
        scheduler = scheduler_of(task)
        with CancelScope(task) as scope:
            scheduler.when_settled(partial(log.append, "rest"))
            acts_at_end(scheduler, scope, partial(log.append, "deadline"))
            scheduler.choose(Deadline(scope, partial(log.append, "choice")))
            await task.step()
            await task.step()
            log.append("step")
            await task.sleep(1.0)

    await run(main)
    assert log == ["step", "choice", "deadline", "rest"]


async def test_an_inner_deadline_acts_first_and_may_spare_the_outer_one() -> None:
    log: list[str] = []

    async def main(task: Task) -> None:
        scheduler = scheduler_of(task)
        with CancelScope(task) as outer:
            outer_one = acts_at_end(scheduler, outer, partial(log.append, "outer"))
            with CancelScope(task) as inner:
                acts_at_end(scheduler, inner, partial(inner.cancel, "late"))
                await task.sleep_forever()
            log.append(inner.outcome)
            outer_one.over = True
            await task.sleep(1.0)

    await run(main)
    assert log == ["late"]


async def test_an_end_in_the_instant_of_the_deadline_is_in_time() -> None:
    async def main(task: Task) -> str:
        scheduler = scheduler_of(task)
        with CancelScope(task) as scope:
            scheduler.act_at(1.0, deadline := Deadline(scope, partial(scope.cancel, "late")))
            await task.sleep(1.0)
            deadline.over = True
            return "in time"
        return str(scope.outcome)

    assert (await run(main)).outcome == "in time"


async def test_a_timer_acts_before_the_first_cycle_of_its_instant() -> None:
    log: list[str] = []

    async def main(task: Task) -> None:
        scheduler_of(task).act_at(1.0, Timer(lambda: log.append(f"timer {scheduler_of(task).now:g}")))
        await task.sleep(1.0)
        log.append("task")

    await run(main)
    assert log == ["timer 1", "task"]


# -------------------------------------------------------- the outside world


async def test_virtual_time_stands_still_while_a_task_is_outside() -> None:
    answer = asyncio.get_running_loop().create_future()

    async def ask(task: Task) -> float:
        asyncio.get_running_loop().call_later(0.01, answer.set_result, None)
        await outside(task, answer)
        return task.scheduler.now

    async def main(task: Task) -> list[float]:
        async with TaskGroup(task) as group:
            asking = group.start_soon(ask)
            await task.sleep(3600.0)
        return [asking.outcome, task.scheduler.now]

    assert (await run(main)).outcome == [0.0, 3600.0]


async def test_a_deadline_waits_for_a_task_outside() -> None:
    async def main(task: Task) -> list[object]:
        scheduler = scheduler_of(task)
        with CancelScope(task) as scope:
            acts_at_end(scheduler, scope, partial(scope.cancel, "late"))
            await outside(task, asyncio.sleep(0.01))
            log = ["back in time"]
            await task.sleep(1.0)
        return [*log, scope.outcome, task.scheduler.now]

    assert (await run(main)).outcome == ["back in time", "late", 0.0]


async def test_a_task_that_comes_back_when_the_run_is_over_is_cancelled() -> None:
    root = await run(end_at_once)
    with pytest.raises(asyncio.CancelledError):
        scheduler_of(root).readmit(root)


async def test_outside_calls_act_in_an_instant() -> None:
    log: list[str] = []

    async def main(task: Task) -> None:
        scheduler, waiter = scheduler_of(task), Waiter(task)
        loop = asyncio.get_running_loop()
        loop.call_soon(scheduler.act_now, partial(log.append, "act"))
        loop.call_later(0.01, scheduler.wake_now, waiter)
        await scheduler.wait(waiter)
        log.append("woken")

    await run(main, clock=RealClock())
    assert log == ["act", "woken"]


async def test_outside_calls_after_the_run_act_at_once() -> None:
    log: list[str] = []
    scheduler_of(await run(end_at_once)).act_in_instant(partial(log.append, "late"))
    assert log == ["late"]


# -------------------------------------------------------- the end of a run


async def test_a_run_without_possible_events_is_stuck() -> None:
    with pytest.raises(Stuck, match="nothing can happen any more"):
        await run(Task.sleep_forever)


async def test_a_handler_decides_the_result_of_a_stuck_run() -> None:
    calls: list[str] = []

    async def main(task: Task) -> str:
        await scheduler_of(task).wait(waiter)
        return "woken"

    def stuck() -> None:
        calls.append("stuck")
        scheduler.wake(waiter)

    scheduler = Scheduler(VirtualClock(), stuck)
    root = scheduler.start_root(main)
    waiter = Waiter(root)
    await scheduler.run()
    assert (root.outcome, calls) == ("woken", ["stuck"])


class FailingClock(VirtualClock):
    """A clock that fails at a time."""

    def skip(self, due: float) -> bool:
        return due < 2.0 and super().skip(due)

    async def pass_time(self, due: float | None, interrupt: asyncio.Event) -> None:
        raise ConnectionError("the simulator is gone")


async def test_time_stands_still_when_the_clock_fails() -> None:
    log: list[object] = []

    async def main(task: Task) -> None:
        try:
            await task.sleep(1.0)
            await task.sleep(1.0)
        finally:
            log.append(task.scheduler.now)
            await task.step()
            log.append(scheduler_of(task).has_clock_failed)

    with pytest.raises(ConnectionError, match="gone"):
        await run(main, clock=FailingClock())
    assert log == [1.0, True]


async def test_a_defect_of_a_task_ends_the_others_in_order_and_is_raised() -> None:
    log: list[str] = []

    async def hold(task: Task, name: str) -> None:
        try:
            await task.sleep_forever()
        finally:
            await task.sleep(1.0)
            log.append(f"{name} {task.scheduler.now:g}")

    async def fail(task: Task) -> None:
        await task.sleep(1.0)
        raise ZeroDivisionError("a defect")

    async def main(task: Task) -> None:
        async with TaskGroup(task) as group:
            group.start_soon(hold, "first")
            group.start_soon(hold, "second")
            group.start_soon(fail)

    with pytest.raises(ZeroDivisionError, match="a defect"):
        await run(main)
    assert log == ["second 2", "first 3"]
    assert other_tasks() == set()


def fail() -> None:
    raise ValueError


async def test_a_defect_of_an_effect_does_not_keep_others_from_being_committed() -> None:
    log: list[str] = []
    defects: list[Exception] = []

    async def main(task: Task) -> None:
        scheduler_of(task).at_commit((0,), fail)
        scheduler_of(task).at_commit((1,), partial(log.append, "committed"))
        await task.sleep(0.0)

    await run(main, defect=defects.append)
    assert log == ["committed"]
    assert [type(error) for error in defects] == [ValueError]


async def test_cancelling_the_awaiting_task_cancels_the_root_task() -> None:
    log: list[str] = []

    async def main(task: Task) -> None:
        try:
            await outside(task, asyncio.get_running_loop().create_future())
        finally:
            await task.step()
            log.append("cleaned up")

    scheduler = Scheduler(VirtualClock())
    scheduler.start_root(main)
    awaiting = asyncio.ensure_future(scheduler.run())
    await asyncio.sleep(0.01)
    awaiting.cancel()
    with pytest.raises(asyncio.CancelledError):
        async with asyncio.timeout(LIMIT):
            await awaiting
    assert log == ["cleaned up"]


async def test_the_meaning_of_a_cancellation_can_be_set() -> None:
    async def main(task: Task) -> str:
        await scheduler_of(task).wait(waiter)
        return "ended by itself"

    scheduler = Scheduler(RealClock())
    root = scheduler.start_root(main)
    waiter = Waiter(root)
    awaiting = asyncio.ensure_future(scheduler.run(on_cancel=partial(scheduler.wake_now, waiter)))
    await asyncio.sleep(0.01)
    awaiting.cancel()
    with pytest.raises(asyncio.CancelledError):
        async with asyncio.timeout(LIMIT):
            await awaiting
    assert root.outcome == "ended by itself"


async def test_an_aborted_run_leaves_no_task() -> None:
    async def main(task: Task) -> None:
        async with TaskGroup(task) as group:
            group.start_soon(Task.sleep_forever)
            group.start_soon(Task.sleep_forever)
            asyncio.get_running_loop().call_soon(scheduler_of(task).abort)

    async with asyncio.timeout(LIMIT):
        root = await run(main, clock=RealClock())
    assert not root.alive
    assert other_tasks() == set()


async def test_a_long_run_leaves_turns_to_the_rest_of_the_program() -> None:
    turns = 0

    async def count_turns() -> None:
        nonlocal turns
        while True:
            turns += 1
            await asyncio.sleep(0)

    async def main(task: Task) -> None:
        for _ in range(1000):
            await task.sleep(1.0)

    counting = asyncio.ensure_future(count_turns())
    await run(main)
    counting.cancel()
    assert turns > 10
