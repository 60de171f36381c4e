"""`Task`: one thread of control; wraps one `asyncio.Task`.

Contract:

- A task belongs to one `TaskGroup`, which joins it; the root task belongs to `Scheduler.run`.
- It takes steps in the order of paths. A step lasts from one wait on the scheduler (`step`, `wait`) to the next; a
  `step` before all other waits begins the first one, and takes no delta cycle.
- Code in a task waits on its own task only; other waits use `Scheduler.leave` and `readmit`.
- It is cancelled by scope (`cancel_scope.py`), or as a whole; each cancellation arrives once.
- `outcome` is the result of its function; None if the task was cancelled as a whole.

A task does not receive occurrences that it has sent or received; its `CausalPast` keeps them. Those in the past of
the task that started it, and of tasks that it has joined, are excluded too (7.6.2.5). An occurrence belongs to one
instant, so a past keeps one instant only.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Coroutine, Iterator
from typing import Any, Protocol, TypeAlias


class CausalPast:
    """Numbers of the occurrences of one instant that were sent or received, and the cause of the next steps.

    Attributes:
        cause: Number of the record that brought about the present state, for the trace; the kernel only passes it
            on.
    """

    __slots__ = ("_instant", "_numbers", "cause")

    def __init__(self, cause: int | None = None) -> None:
        self.cause = cause
        self._numbers: set[int] | None = None  # None while empty, as in most tasks
        self._instant = -1

    def add(self, number: int, instant: int) -> None:
        """Add an occurrence of an instant; drop those of earlier instants."""
        if self._instant != instant or self._numbers is None:
            self._numbers, self._instant = {number}, instant
        else:
            self._numbers.add(number)

    def contains(self, number: int, instant: int) -> bool:
        """Whether it contains an occurrence of an instant."""
        return self._instant == instant and self._numbers is not None and number in self._numbers

    def fork(self) -> CausalPast:
        """Return a copy, for a started task or for a subscription."""
        other = CausalPast(self.cause)
        if self._numbers:
            other._numbers, other._instant = set(self._numbers), self._instant
        return other

    def join(self, other: CausalPast) -> None:
        """Add the past of an ended task or of a subscription."""
        if not other._numbers or other._instant < self._instant:
            return
        if other._instant == self._instant and self._numbers is not None:
            self._numbers |= other._numbers
        else:
            self._numbers, self._instant = set(other._numbers), other._instant


TaskFunction: TypeAlias = Callable[..., Coroutine[Any, Any, Any]]
"""Called with the task and the arguments of `start_soon`."""

Guard: TypeAlias = "Callable[[Task, Callable[[], None]], None]"
"""Called at commit when the first wait of a task is over, with the function that resumes the task."""


class Waiter:
    """One wait of a task; `Scheduler.wake` ends it, once, with a value."""

    __slots__ = ("over", "task", "value", "woken")

    def __init__(self, task: Task) -> None:
        self.task = task
        self.woken = False
        self.value: Any = None
        self.over = False  # whether the task has stopped waiting


class TaskScheduler(Protocol):
    """Scheduler as seen by tasks, scopes and groups."""

    cause: int | None  # of the effect that is being committed; see `CausalPast`

    @property
    def now(self) -> float:
        """Time of the present instant [s]."""

    def step(self, task: Task) -> Awaitable[None]:
        """End a step; the next one is in the next delta cycle."""

    def wait(self, waiter: Waiter) -> Coroutine[Any, Any, Any]:
        """End a step until the waiter is woken; return its value."""

    def wake(self, waiter: Waiter, value: Any = None) -> None:
        """Wake a waiter at the next commit."""

    def wake_at(self, time: float, waiter: Waiter) -> None:
        """Wake a waiter in the first instant at or after a time [s]."""

    def at_commit(self, path: tuple[int, ...], effect: Callable[[], None], cause: int | None = None) -> None:
        """Commit an effect that cancels tasks after this delta cycle, in order of paths.

        Args:
            path: Its position.
            effect: The effect.
            cause: Its cause; by default, that of the effect that is being committed.
        """

    def start(self, task: Task, function: TaskFunction, args: tuple[Any, ...], create: CreateTask) -> None:
        """Schedule the first step of a task in the next delta cycle."""

    def deliver_cancel(self, task: Task) -> None:
        """Cancel a task in the next delta cycle, before all steps."""


CreateTask: TypeAlias = Callable[..., "asyncio.Task[None]"]  # `asyncio.TaskGroup.create_task`


class Scope:
    """Part of a task that is cancelled as a whole, with all tasks started in it; `CancelScope` opens one.

    Args:
        task: The task.
    """

    __slots__ = ("depth", "is_open", "outcome", "outer", "task")

    def __init__(self, task: Task) -> None:
        self.task = task
        self.outcome: Any = None  # set by its cancellation
        self.depth = 0  # nesting depth in its task; the outermost scope has 1
        self.outer: Scope | None = None  # surrounding scope, in this task or in the one that started it
        self.is_open = False

    @property
    def around(self) -> Iterator[Scope]:
        """Surrounding scopes, from the nearest."""
        scope = self.outer
        while scope is not None:
            yield scope
            scope = scope.outer


class Task:
    """One thread of control.

    Args:
        scheduler: Scheduler of its steps.
        path: Its position in the tree of tasks, which orders steps of one delta cycle.
        parent: The task that starts it; None for the root.
        cycle: Number of the delta cycle in which it is started.
    """

    __slots__ = (
        "alive",
        "awaits_answer",
        "cancel_delivered",
        "cancel_seen_next",
        "cancelled_at",
        "cancelled_depth",
        "children",
        "cycle",
        "depth",
        "foreign",
        "fresh",
        "guard",
        "handle",
        "on_cancel",
        "on_end",
        "outcome",
        "outside",
        "overran",
        "parent",
        "parent_depth",
        "parked",
        "past",
        "path",
        "scheduler",
        "scope",
    )

    def __init__(self, scheduler: TaskScheduler, path: tuple[int, ...], parent: Task | None, cycle: int) -> None:
        self.scheduler = scheduler
        self.path = path
        self.parent = parent
        self.cycle = cycle
        self.handle: asyncio.Task[None] | None = None  # once it has begun
        self.children: dict[Task, None] | None = None  # live children, in order of starts
        self.on_end: list[Callable[[Task], None]] | None = None  # called at commit, once it has ended
        self.on_cancel: Callable[[], None] | None = None  # called when a cancellation is about to arrive
        self.guard: Guard | None = None
        self.outcome: Any = None
        self.alive = True
        self.cancelled_depth = -1  # depth of the outermost cancelled scope; 0 for the whole task, -1 for none
        self.cancel_delivered = False
        self.cancelled_at = 0.0  # [s, monotonic]
        self.overran = False  # whether the clean-up since then took too long
        self.cancel_seen_next = False  # whether the next `CancelledError` comes from the scheduler
        self.fresh = True  # until its first step
        self.awaits_answer = False  # whether its outside wait takes no time of the run
        self.parked: asyncio.Future[Any] | None = None  # awaited future of the scheduler
        self.foreign: asyncio.Future[Any] | None = None  # awaited future outside
        self.outside = False
        self.depth = 0  # number of open scopes
        if parent is None:
            self.scope: Scope | None = None  # innermost open scope
            self.parent_depth = 0
            self.past = CausalPast()
        else:
            self.scope = parent.scope
            self.parent_depth = parent.depth
            self.past = parent.past.fork()

    @property
    def is_cancelled(self) -> bool:
        """Whether the task or one of its open scopes is cancelled."""
        return self.cancelled_depth >= 0

    def step(self) -> Awaitable[None]:
        """End this step; the next one is in the next delta cycle."""
        return self.scheduler.step(self)

    def sleep_until(self, time: float) -> Coroutine[Any, Any, None]:
        """Wait until a time of the scheduler's clock [s]; a past time ends this step."""
        waiter, scheduler = Waiter(self), self.scheduler
        if time <= scheduler.now:
            scheduler.wake(waiter)
        else:
            scheduler.wake_at(time, waiter)
        return scheduler.wait(waiter)

    def sleep(self, duration: float) -> Coroutine[Any, Any, None]:
        """Wait for a duration of the scheduler's clock [s]."""
        return self.sleep_until(self.scheduler.now + duration)

    def sleep_forever(self) -> Coroutine[Any, Any, None]:
        """Wait until it is cancelled."""
        return self.scheduler.wait(Waiter(self))

    def when_ended(self, act: Callable[[Task], None]) -> None:
        """Register a callback at commit after its end."""
        if self.on_end is None:
            self.on_end = []
        self.on_end.append(act)

    def notify_end(self) -> None:
        """Call the callbacks that were registered for its end."""
        for act in self.on_end or ():
            act(self)

    def descendants(self, depth: int = 0) -> list[Task]:
        """Return live tasks started in it, directly or indirectly, in order of starts.

        Args:
            depth: Minimum depth of the scope in which they, or their ancestors, were started.
        """
        pending = [child for child in self.children or () if child.parent_depth >= depth]
        found: list[Task] = []
        while pending:
            task = pending.pop()
            found.append(task)
            if task.children:
                pending.extend(task.children)
        found.sort(key=lambda task: (task.cycle, task.path))
        return found


async def abandon(root: Task, grace: float) -> None:
    """Cancel the remaining tasks after a defect; otherwise none are left."""
    for task in reversed((root, *root.descendants())):
        if task.handle is not None and task.alive:
            task.handle.cancel()
            await asyncio.wait({task.handle}, timeout=grace)
