"""`Stepping`: steps of tasks in delta cycles until the instant has settled; the lower half of the scheduler.

A task is busy from its release until it parks. When the last busy task parks, the next tasks are released in that
call, and the event loop resumes them in order. A task that is alone continues without a switch.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable
from contextvars import Context, copy_context
from functools import partial
from typing import Any, Final

from seoro.runtime.kernel.cancel_scope import absorb_cancel
from seoro.runtime.kernel.delta import Act, Commit, DeltaCycle, Effects, StepOrder
from seoro.runtime.kernel.settling import READY, parked
from seoro.runtime.kernel.stack import carried
from seoro.runtime.kernel.task import CreateTask, Task, TaskFunction, Waiter

TOGETHER: Final = 64  # tasks released together; then other tasks of the event loop run
SLICE: Final = 0.05  # [s] of the machine's clock for steps in a row; then other tasks of the event loop run
LOOK_EVERY: Final = 8  # steps between looks at the machine's clock


class Stepping:
    """Steps of tasks, and the commits between them.

    Args:
        defect: Called with the exception of a task or an effect, which is a defect.
        step_order: Returns the sort key of a task's path in a cycle; by default, the path itself. No task sees an
            effect of its own cycle, so the order affects the order of records only. For tests.
    """

    def __init__(self, defect: Callable[[Exception], None], step_order: StepOrder | None) -> None:
        self._loop = asyncio.get_running_loop()
        self._defect = defect
        self._is_open = False  # whether the instant has not settled
        self._is_finished = False
        self._alive = 0  # tasks that have not ended
        self._busy = 0  # tasks that take a step
        self._parking: Task | None = None  # task in whose call the next ones are released
        self._cycle = DeltaCycle(step_order, self._cancel)
        self._effects = Commit(defect)
        self._woken: list[Waiter] = []
        self._slice_end = 0.0  # [s] of the machine's clock
        self.together = TOGETHER  # steps released at once; 1 if a step may be held up
        self._steps = 0  # since the last look at the clock
        self._holds_cycle = False  # whether the next cycle waits for an external answer
        self._has_effects = False  # whether any effect is pending
        self._yields = False  # whether other tasks of the event loop run within an instant

    # -------------------------------------------------------- implemented by the upper half

    def _poke(self) -> None:
        """Note that there is new work."""
        raise NotImplementedError

    def _settle(self) -> bool:
        """Continue when no step is left; return False if nothing can continue in this instant."""
        raise NotImplementedError

    def _take_back(self, task: Task) -> bool:
        """Take back a task that is outside; return whether it was outside."""
        raise NotImplementedError

    # -------------------------------------------------------- tasks

    @property
    def cause(self) -> int | None:
        """Cause of the effect that is being committed, or of the timer that acts; see `CausalPast`."""
        return self._effects.cause

    @cause.setter
    def cause(self, cause: int | None) -> None:
        self._effects.cause = cause

    @property
    def cycle(self) -> int:
        """Number of the present delta cycle."""
        return self._cycle.number

    def start(self, task: Task, function: TaskFunction, args: tuple[Any, ...], create: CreateTask) -> None:
        """Schedule the first step of a task in the next delta cycle.

        Args:
            task: The task.
            function: Its function; called with the task and `args`.
            args: Arguments of `function`.
            create: Creates its `asyncio.Task`.
        """
        if task.parent is not None:
            if task.parent.children is None:
                task.parent.children = {}
            task.parent.children[task] = None
        self._alive += 1
        begin = partial(self._begin, task, function, args, create, copy_context())
        self._cycle.add(task.path, begin, task)
        self._poke()

    def _begin(
        self, task: Task, function: TaskFunction, args: tuple[Any, ...], create: CreateTask, context: Context
    ) -> None:
        """Create the `asyncio.Task` of a task, unless it was cancelled meanwhile."""
        if not task.is_cancelled:
            self._busy += 1
            task.handle = create(self._main(task, function, args), context=context)

    async def _main(self, task: Task, function: TaskFunction, args: tuple[Any, ...]) -> None:
        try:
            task.outcome = await carried(function(task, *args))
        except asyncio.CancelledError:
            if task.cancelled_depth != 0:
                raise
            absorb_cancel(task)
        except Exception as error:
            self._defect(error)
        finally:
            self._end(task)
            self._busy -= 1
            if self._busy == 0:
                if task.parent is not None and task.parent.children:
                    self._advance()
                else:
                    # Later, when this `asyncio.Task` is done: a parent that continues finds all its children done.
                    self._loop.call_soon(self._advance)

    def _end(self, task: Task) -> None:
        task.alive = False
        self._alive -= 1
        if task.parent is not None and task.parent.children is not None:
            del task.parent.children[task]
        if task.on_end is not None:
            self.at_commit(task.path, task.notify_end, task.past.cause)

    def step(self, task: Task) -> Awaitable[None]:
        """Wait for the next delta cycle, or take the first step of a task in the cycle of its release."""
        if task.fresh:
            task.fresh = False
            return READY
        if self._continues_alone():
            return READY
        future = self._resume_next(task)
        self._park(task)
        return parked(task, future)

    def _continues_alone(self) -> bool:
        """Whether the only busy task is all of the next cycle, which then begins in this call."""
        cycle = self._cycle
        if self._busy > 1 or cycle.present or cycle.has_next or self._holds_cycle:
            return False
        self._steps += 1
        if self._steps > LOOK_EVERY:
            if time.monotonic() > self._slice_end:
                return False
            self._steps = 0
        while self._has_effects:
            self._commit()
        if cycle.has_next:
            return False
        cycle.number += 1
        return True

    async def wait(self, waiter: Waiter) -> Any:
        """Wait until the waiter is woken; return its value."""
        task = waiter.task
        task.fresh = False
        future = task.parked = self._loop.create_future()
        self._park(task)
        try:
            return await parked(task, future)
        finally:
            waiter.over = True

    def _resume_next(self, task: Task, alone: bool = False) -> asyncio.Future[Any]:
        """Schedule a parked task for the next cycle."""
        future = task.parked = self._loop.create_future()
        self._cycle.add(task.path, partial(self._resume, task, future, None), task, alone)
        return future

    def _park(self, task: Task) -> None:
        self._busy -= 1
        if self._busy == 0:
            self._parking = task
            self._advance()
            self._parking = None

    def _resume(self, task: Task, future: asyncio.Future[Any], value: Any) -> None:
        """Resume a parked task, unless it was cancelled or resumed meanwhile."""
        if future.done() or (task.is_cancelled and not task.cancel_delivered):
            return
        self._busy += 1
        future.set_result(value)

    # -------------------------------------------------------- cancelling

    def deliver_cancel(self, task: Task) -> None:
        """Cancel a task in the next delta cycle, before all steps."""
        self._cycle.cancel(task)
        self._poke()

    def _cancel(self, task: Task) -> None:
        foreign = task.foreign
        if self._take_back(task):  # immediately, so that the cycle waits for its clean-up
            self._announce_cancel(task)
            if foreign is not None:
                foreign.cancel()
        elif task.parked is not None and not task.parked.done():
            self._announce_cancel(task)
            task.parked.cancel()
        elif task.handle is None and task.alive:
            self._end(task)  # before its first step

    def _announce_cancel(self, task: Task) -> None:
        """Note that the cancellation is about to reach the task."""
        self._busy += 1
        task.cancel_seen_next = True
        if task.on_cancel is not None:
            task.on_cancel()

    # -------------------------------------------------------- waking, steps and effects

    def wake(self, waiter: Waiter, value: Any = None) -> None:
        """Wake a waiter at the next commit."""
        if not (waiter.woken or waiter.over):
            waiter.value = value
            if self._effects.cause is not None and not waiter.task.is_cancelled:
                waiter.task.past.cause = self._effects.cause
            self._add_woken(waiter)
            self._poke()

    def _add_woken(self, waiter: Waiter) -> None:
        waiter.woken = True
        self._has_effects = True
        self._woken.append(waiter)

    def react(self, path: tuple[int, ...], step: Act) -> None:
        """Take a step in the next cycle that belongs to no task, and awaits nothing."""
        self._cycle.add(path, step)
        self._poke()

    def write(self, path: tuple[int, ...], effect: Act) -> None:
        """Commit a change of a variable after this cycle, before all other effects, in order of paths."""
        self._add_effect(self._effects.writes, path, effect)

    def check(self, path: tuple[int, ...], effect: Act) -> None:
        """Commit a check of a condition, after all changes of variables, in order of paths."""
        self._add_effect(self._effects.checks, path, effect)

    def at_commit(self, path: tuple[int, ...], effect: Act, cause: int | None = None) -> None:
        """Commit an effect that cancels tasks, in order of paths; see `TaskScheduler`."""
        self._add_effect(self._effects.cancellations, path, effect, cause)

    def send(self, key: tuple[str, str], effect: Act) -> None:
        """Commit a message of a channel, after cancellations, in the order of channels and messages."""
        self._add_effect(self._effects.sends, key, effect)

    def after_sends(self, effect: Act) -> None:
        """Commit the end of a subscription, after all messages of the same cycle."""
        self._add_effect(self._effects.closings, None, effect)

    def _add_effect(self, effects: Effects, key: object, effect: Act, cause: int | None = None) -> None:
        """Add an effect to its kind; it is committed after this cycle."""
        self._has_effects = True
        effects.append((key, effect, self._effects.cause if cause is None else cause))
        self._poke()

    def _commit(self) -> None:
        effects = self._effects
        effects.run()
        if self._woken:
            self._resume_woken()
        self._has_effects = effects.is_due

    def _resume_woken(self) -> None:
        woken = [waiter for waiter in self._woken if not waiter.over]
        self._woken.clear()
        if len(woken) > 1:
            woken.sort(key=lambda waiter: waiter.task.path)
        for waiter in woken:
            task = waiter.task
            assert task.parked is not None
            resume = partial(self._resume, task, task.parked, waiter.value)
            if task.guard is None or task.is_cancelled:
                self._cycle.add(task.path, resume, task)
            else:
                guard, task.guard = task.guard, None
                guard(task, partial(self._cycle.add, task.path, resume, task))

    def _advance(self) -> None:
        """Take the next steps, and commit effects between cycles. Exceptions are reported as defects."""
        while True:
            try:
                return self._run_cycles()
            except Exception as error:
                self._defect(error)

    def _run_cycles(self) -> None:
        cycle = self._cycle
        while self._is_open and self._busy == 0 and not self._yields:
            if cycle.present:
                if self._steps > LOOK_EVERY and self._is_yielding():
                    return
                self._release()
            elif self._holds_cycle:
                return
            else:
                while self._has_effects:
                    self._commit()
                if cycle.has_next:
                    cycle.begin()
                elif not self._settle():
                    return

    def _release(self) -> None:
        """Take a step that belongs to no task, or release consecutive tasks."""
        present = self._cycle.present
        for _ in range(self.together):
            _, act, task, alone = present[0]
            if self._busy and (alone or task is None or task is self._parking):
                return  # a task that parks in this call would overtake those before it
            present.popleft()
            self._steps += 1
            act()
            if alone or task is None or not present:
                return

    def _is_yielding(self) -> bool:
        """Whether other tasks of the event loop run first, for example to stop the run.

        The run is suspended meanwhile, so that its result does not depend on the speed of the machine. After its
        last task there is nothing to stop.
        """
        self._steps = 0
        if self._alive and time.monotonic() > self._slice_end:
            self._yields = True
            self._loop.call_soon(self._end_yield)
        return self._yields

    def _end_yield(self) -> None:
        self._yields = False
        self._begin_slice()
        if not self._is_finished:
            self._advance()

    def _begin_slice(self) -> None:
        """Note that other tasks of the event loop have run."""
        self._slice_end = time.monotonic() + SLICE
