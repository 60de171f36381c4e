"""`Scheduler`: instants and delta cycles: which task steps next, when effects are committed, when time advances.

Contract:

- Everything happens in instants, each at one value of `now`. An instant is a sequence of delta cycles.
- In a delta cycle every ready task takes one step, in the order of paths. Effects are collected, and committed
  between cycles (`delta.py`), so that no task sees an effect of its own cycle.
- If no task is ready, the instant has settled: choices are made, deadlines act (`settling.py`), and then time may
  advance.
- A task that awaits the outside world is `outside`: cycles go on without it. On deterministic clocks, time waits
  for it; during a request to a backend (`awaits_answer`), even the cycle waits.
- Exceptions where none is allowed are reported as defects; other tasks continue.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Coroutine
from functools import partial
from typing import Any, Final

from seoro.runtime.kernel.advance import Stuck, TimeAdvance
from seoro.runtime.kernel.cancel_scope import cancel_task
from seoro.runtime.kernel.clock import NEXT, TIME_DIGITS, Clock
from seoro.runtime.kernel.delta import StepOrder
from seoro.runtime.kernel.settling import Settling
from seoro.runtime.kernel.stepping import Stepping
from seoro.runtime.kernel.task import Task, TaskFunction, Waiter, abandon
from seoro.runtime.kernel.timers import Deadline, Timer, TimerQueue

GRACE: Final = 5.0  # [s] of the machine's clock


class Scheduler(Stepping):
    """Order of all steps in one run. Create it inside the event loop.

    By default, errors cancel the root task, and `run` raises them.

    Args:
        clock: The run's clock.
        stuck: Called when nothing can happen any more.
        clock_failed: Called when the clock raises; time then stands still.
        defect: Called with the exception of a task or an effect.
        step_order: See `Stepping`.
    """

    def __init__(
        self,
        clock: Clock,
        stuck: Callable[[], None] | None = None,
        clock_failed: Callable[[Exception], None] | None = None,
        defect: Callable[[Exception], None] | None = None,
        step_order: StepOrder | None = None,
    ) -> None:
        super().__init__(defect or self._fail, step_order)
        self.now = 0.0  # [s] of the present instant
        self.instant = 0  # its number
        self.is_exact: Final = clock.deterministic  # whether instants are exactly at the times of timers
        self._clock = clock
        self._timers = TimerQueue()
        self._settling = Settling()
        self._time = TimeAdvance(
            clock, self._timers, stuck or partial(self._fail, Stuck()), clock_failed or self._fail
        )
        self._settled = asyncio.Event()
        self._done = asyncio.Event()
        self._root: Task | None = None
        self._error: Exception | None = None  # first error, raised by `run`
        self._asyncio_group = asyncio.TaskGroup()  # of the root task
        self._outside = 0  # tasks that await the outside world
        self._asking = 0  # of these, tasks whose answer takes no time of the run
        self._held: list[Callable[[], object]] = []  # external calls since the last instant
        self._began_on_arrival = False  # whether `_drive` must be notified of the present instant

    @property
    def has_clock_failed(self) -> bool:
        """Whether time stands still, because the clock has raised or timed out."""
        return self._time.has_failed

    # -------------------------------------------------------- the run

    def start_root(self, function: TaskFunction, *args: Any) -> Task:
        """Create the root task, which takes its first step in `run`.

        Args:
            function: Called with the root task and `args`.
            args: Arguments of `function`.
        """
        root = self._root = Task(self, (), None, self.cycle)
        root.when_ended(lambda _: self._done.set())
        self.start(root, function, args, self._asyncio_group.create_task)
        return root

    async def run(
        self,
        on_cancel: Callable[[], None] | None = None,
        grace: float = GRACE,
        at_end: Callable[[], Awaitable[None]] | None = None,
    ) -> None:
        """Run until the root task has ended.

        Args:
            on_cancel: Called when the task that awaits this is cancelled; by default, the root task is cancelled.
            grace: Time for each task to end after a defect [s].
            at_end: Called when all tasks have ended, before tasks started beside them are joined.

        Raises:
            asyncio.CancelledError: The task that awaits this was cancelled; all tasks have ended.
            Exception: An error that no callback handles; all tasks have ended.
        """
        assert self._root is not None, "`start_root` comes first"
        root, cancelled = self._root, False
        cancel = partial(self.at_commit, (), partial(cancel_task, root)) if on_cancel is None else on_cancel
        async with self._asyncio_group as group:
            group.create_task(self._drive())
            while not self._done.is_set():
                try:
                    await self._done.wait()
                except asyncio.CancelledError:
                    cancelled = True
                    cancel()
            self._finish()
            await abandon(root, grace)
            if at_end is not None:
                await at_end()
        if cancelled:
            raise asyncio.CancelledError from self._error
        if self._error is not None:
            raise self._error

    def start_beside(self, coroutine: Coroutine[Any, Any, None]) -> asyncio.Task[None]:
        """Start a task of the event loop beside the run; the run joins it."""
        return self._asyncio_group.create_task(coroutine)

    def _fail(self, error: Exception) -> None:
        """Cancel the root task, and abort if that takes too long; `run` raises the first error."""
        if self._error is None:
            self._error = error
            self._loop.call_later(GRACE, self.abort)
        if self._root is not None:
            self.at_commit((), partial(cancel_task, self._root))

    def abort(self) -> None:
        """End the run although its root task has not ended, for example after a defect."""
        self._done.set()

    def cut_grace(self) -> None:
        """Limit the wait for a hanging simulator: the run has been stopped."""
        if not self._is_finished:
            self._time.cut_grace()

    def _finish(self) -> None:
        self._is_finished = True
        self._act_held()
        self._time.interrupt()
        self._settled.set()  # after a defect, the instant may never settle

    def wake_at(self, time: float, waiter: Waiter) -> None:
        """Wake a waiter in the first instant at or after a time [s]."""
        self._timers.add(time, waiter)

    def act_at(self, time: float, entry: Timer | Deadline) -> None:
        """Let a timer or a deadline act in the first instant at or after a time [s]."""
        self._timers.add(time, entry)

    def choose(self, choice: Deadline) -> None:
        """Make a choice when the instant has otherwise settled, before deadlines act."""
        self._settling.choices.append(choice)

    def when_settled(self, act: Callable[[], None]) -> None:
        """Call a function when the instant has otherwise settled, after deadlines; tasks may be outside."""
        self._settling.rest.append(act)

    # -------------------------------------------------------- the outside world

    def leave(self, task: Task, foreign: asyncio.Future[Any] | None) -> None:
        """End a step: the task awaits the outside world."""
        task.outside, task.foreign = True, foreign
        self._count_outside(task, 1)
        self._busy -= 1
        self._advance()

    def readmit(self, task: Task) -> asyncio.Future[Any]:
        """Readmit a task that something outside of the scheduler has resumed.

        Returns:
            Future to await: the task continues in the next cycle.

        Raises:
            asyncio.CancelledError: The run is over.
        """
        if self._is_finished:
            raise asyncio.CancelledError
        self._take_back(task)
        future = self._resume_next(task, alone=True)
        if self._is_open:
            self._advance()
        else:
            self._time.interrupt()
        return future

    def _take_back(self, task: Task) -> bool:
        if not task.outside:
            return False
        task.outside, task.foreign = False, None
        self._count_outside(task, -1)
        return True

    def _count_outside(self, task: Task, change: int) -> None:
        self._outside += change
        self._asking += change * task.awaits_answer
        self._holds_cycle = self._asking > 0 and self.is_exact

    def expect(self, count: int) -> None:
        """Add to the number of reports that backends will send as time goes on."""
        self._time.expected += count

    def wake_now(self, waiter: Waiter) -> None:
        """Wake a task that waits for the outside world.

        On real clocks, an instant begins in this call, which saves a turn of the event loop; `_drive` notices when
        it has settled.
        """
        if not self._begins_on_arrival:
            self.wake(waiter)
        elif not (waiter.woken or waiter.over):
            self._add_woken(waiter)
            self._begin_on_arrival()

    def act_now(self, act: Callable[[], None]) -> None:
        """Call a function for an external event, in this instant or in one that begins in this call.

        On deterministic clocks, it is called in the next instant.
        """
        if self._begins_on_arrival:
            self._held.append(act)
            self._begin_on_arrival()
        else:
            self.act_in_instant(act)

    def act_in_instant(self, act: Callable[[], object], *, can_wait: bool = False) -> None:
        """Call a function in the present instant if one is open, otherwise in the next.

        After the last instant, it is called at once. On exact clocks, one that can wait causes no instant.
        """
        if self._is_open or self._is_finished:
            act()
        else:
            self._held.append(act)
            if not (can_wait and self.is_exact):
                self._poke()

    def act_next(self, timer: Timer) -> None:
        """Let a timer act at the start of a new instant, so that its effects are in no past."""
        self._timers.add(self.now + NEXT, timer)
        if self._begins_on_arrival:
            self._begin_on_arrival()
        else:
            self._poke()

    @property
    def _begins_on_arrival(self) -> bool:
        """Whether an external event begins an instant: on real clocks, if none is open."""
        return not (self._is_open or self.is_exact or self._is_finished)

    def _act_held(self) -> None:
        held, self._held = self._held, []
        for act in held:
            act()

    # -------------------------------------------------------- instants

    def _poke(self) -> None:
        if not self._is_open:
            self._time.interrupt()

    async def _drive(self) -> None:
        """Run instants until the run is over."""
        while not self._is_finished:
            if not (self._cycle.has_next or self._has_effects):
                await self._time.pass_time(self._outside > 0)
            self._time.clear()
            if not self._is_finished:
                if not self._is_open:
                    self._begin_apart()
                await self._settled.wait()

    def _begin_on_arrival(self) -> None:
        self._began_on_arrival = True
        self._begin_apart()

    def _begin_apart(self) -> None:
        """Begin an instant after other tasks of the event loop have run."""
        self._time.begin()
        self._begin_slice()
        self._settled.clear()
        self._is_open = True
        try:
            self._begin_instant()
        except Exception as error:
            self._defect(error)
        self._advance()

    def _begin_instant(self) -> None:
        now = round(self._clock.now(), TIME_DIGITS)
        if now > self.now:
            self.now = now
            self.instant += 1
        if self._held:
            self._act_held()
        self._take_due()

    def _take_due(self) -> bool:
        """Process due timers; return whether any acted at once."""
        has_acted = False
        while (due := self._timers.take(self.now)) is not None:
            self.cause = due.cause if isinstance(due, Timer) else None
            if isinstance(due, Waiter):
                self.wake(due)
            elif isinstance(due, Timer):
                due.act()
            else:
                self._settling.deadlines.append(due)
                continue
            has_acted = True
        self.cause = None
        return has_acted

    def _settle(self) -> bool:
        if self._take_due() or (self._settling.is_waited_for and self._act_at_end()) or self._skip():
            return True
        self._is_open = False
        self._settled.set()
        if self._began_on_arrival:
            self._began_on_arrival = False
            self._time.interrupt()
        return False

    def _act_at_end(self) -> bool:
        may_end = self._outside > 0 and self.is_exact  # in this instant, before its deadline
        has_acted = self._settling.act(self._effects.cancellations, with_deadlines=not may_end)
        self._has_effects = self._has_effects or has_acted
        return has_acted

    def _skip(self) -> bool:
        """Begin the next instant in this call, if the clock can."""
        if self._outside or not self._alive or not self._time.skip():
            return False
        self._begin_instant()
        return True
