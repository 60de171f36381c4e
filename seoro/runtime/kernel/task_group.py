"""`TaskGroup`: tasks that are started together, and joined when its block is left.

Contract:

- `async with TaskGroup(task) as group: group.start_soon(function, *args)`; a child takes its first step in the
  next delta cycle.
- Leaving the block joins every child, on every path, even if the parent is cancelled meanwhile. If the block
  raises, the children are cancelled first.
- The past of ended children joins the past of the parent.
- A `Policy` decides on further consequences of the ends of children.
- The group holds a real `asyncio.TaskGroup`, so that the standard library guarantees that no task outlives it. The
  children are joined through the scheduler first, which keeps order and cancellation deterministic.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from types import TracebackType
from typing import Any, Protocol

from seoro.runtime.kernel.cancel_scope import CancelScope, cancel_task
from seoro.runtime.kernel.scheduler import Scheduler
from seoro.runtime.kernel.task import Scope, Task, TaskFunction, Waiter
from seoro.runtime.kernel.timers import Deadline


class Policy(Protocol):
    """Reacts to the ends of children; called at commit."""

    def child_ready(self, child: Task, resume: Callable[[], None]) -> None:
        """Handle the end of the first wait of a guarded child; `resume` lets it continue."""

    def child_ended(self, child: Task) -> None:
        """Handle the end of a child; a cancelled child has the `outcome` None."""


class TaskGroup:
    """Tasks that are joined when the block is left.

    Args:
        task: The parent.
        policy: Reacts to the ends of children; optional.
    """

    __slots__ = (
        "_asyncio_group",
        "_deadlines",
        "_is_interrupted",
        "_oldest",
        "_policy",
        "_scope",
        "_waiter",
        "children",
        "scheduler",
        "task",
    )

    def __init__(self, task: Task, policy: Policy | None = None) -> None:
        self.task = task
        assert isinstance(task.scheduler, Scheduler)
        self.scheduler = task.scheduler
        self.children: list[Task] = []
        self._policy = policy
        self._scope: Scope = task.scope if task.scope is not None else Scope(task)
        self._asyncio_group = asyncio.TaskGroup()
        self._waiter: Waiter | None = None
        self._oldest = 0  # index of the first child that may be alive
        self._is_interrupted = False
        self._deadlines: list[Deadline] = []

    async def __aenter__(self) -> TaskGroup:
        await self._asyncio_group.__aenter__()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if error is not None and not isinstance(error, asyncio.CancelledError):
            self.scheduler.at_commit(self.task.path, self.cancel_all)
        try:
            await self.join()
        finally:
            for child in self.children:
                self.task.past.join(child.past)
            for deadline in self._deadlines:
                deadline.over = True
            await self._asyncio_group.__aexit__(None, None, None)

    # -------------------------------------------------------- children

    @property
    def now(self) -> float:
        """Time of the present instant [s]."""
        return self.scheduler.now

    @property
    def alive(self) -> list[Task]:
        """Children that have not ended."""
        return [child for child in self.children if child.alive]

    @property
    def has_ended(self) -> bool:
        """Whether all children have ended."""
        children = self.children
        while self._oldest < len(children) and not children[self._oldest].alive:
            self._oldest += 1
        return self._oldest == len(children)

    def start_soon(
        self, function: TaskFunction, *args: Any, path: tuple[int, ...] | None = None, guarded: bool = False
    ) -> Task:
        """Start a child; it takes its first step in the next delta cycle.

        Args:
            function: Called with the child and `args`.
            args: Arguments of `function`.
            path: Its position; by default, the parent's and the number of children before it.
            guarded: Whether its policy decides if it continues after its first wait.
        """
        if path is None:
            path = (*self.task.path, len(self.children))
        child = Task(self.scheduler, path, self.task, self.scheduler.cycle)
        child.on_end = [self._child_ended]
        if guarded and self._policy is not None:
            child.guard = self._policy.child_ready
        self.children.append(child)
        self.scheduler.start(child, function, args, self._asyncio_group.create_task)
        return child

    def _child_ended(self, child: Task) -> None:
        if self._policy is not None:
            self._policy.child_ended(child)
        if self.has_ended:
            self._wake()

    def cancel(self, child: Task, because_of: Task | None = None) -> None:
        """Cancel a child. Call at commit.

        Args:
            child: The child.
            because_of: Task whose present state is the cause; by default, the cause of the present effect.
        """
        if because_of is not None:
            self.scheduler.cause = because_of.past.cause
        cancel_task(child)

    def end(self, child: Task, outcome: Any) -> None:
        """Cancel the outermost scope of a child; without one, the whole child. Call at commit.

        Args:
            child: The child.
            outcome: Outcome of the scope.
        """
        scope = child.scope if child.depth else None
        while scope is not None and scope.depth > 1:
            scope = scope.outer
        if isinstance(scope, CancelScope):
            scope.cancel(outcome)
        else:
            cancel_task(child)

    def cancel_all(self) -> None:
        """Cancel all children. Call at commit."""
        for child in self.alive:
            cancel_task(child)

    # -------------------------------------------------------- waiting

    async def join(self) -> None:
        """Wait until all children have ended, even if the parent is cancelled meanwhile.

        Raises:
            asyncio.CancelledError: The parent was cancelled; all children have ended.
        """
        cancelled: asyncio.CancelledError | None = None
        while not self.has_ended:
            try:
                await self._wait()
            except asyncio.CancelledError as error:
                cancelled = error
        if cancelled is not None:
            raise cancelled

    async def wait_until(self, time: float) -> None:
        """Wait until a time [s], or until `interrupt`."""
        while self.scheduler.now < time and not self._is_interrupted:
            await self._wait(time)

    def interrupt(self) -> None:
        """End `wait_until` early, now and from now on."""
        self._is_interrupted = True
        self._wake()

    async def _wait(self, until: float | None = None) -> None:
        """Wait until all children have ended, or the parent is woken otherwise."""
        self._waiter = Waiter(self.task)
        if until is not None:
            self.scheduler.wake_at(until, self._waiter)
        await self.scheduler.wait(self._waiter)

    def _wake(self) -> None:
        if self._waiter is not None:
            self.scheduler.wake(self._waiter)

    # -------------------------------------------------------- for policies

    def after(self, delay: float, act: Callable[[], None]) -> None:
        """Call a function after a delay [s], when that instant has otherwise settled, unless the block is left."""
        deadline = Deadline(self._scope, act)
        self._deadlines.append(deadline)
        self.scheduler.act_at(self.scheduler.now + delay, deadline)

    def choose(self, act: Callable[[], None]) -> None:
        """Call a function when this instant has otherwise settled, before deadlines act."""
        self.scheduler.choose(Deadline(self._scope, act))
