"""`CancelScope`: a block of a task that can be cancelled as a whole.

Contract:

- `with CancelScope(task) as scope:` opens it, within the open scopes of the task.
- `scope.cancel(outcome)`, called at commit, cancels the tasks started in it, last started first, each after the
  clean-up of the previous one; then its own task, which leaves the block. `outcome` is that of the first call.
- A cancelled task takes no further steps: it receives one `CancelledError`, and cleans up.
- The block swallows the `CancelledError` of its own cancellation, and passes on all others.
"""

from __future__ import annotations

import asyncio
import time
from types import TracebackType
from typing import Any

from seoro.runtime.kernel.task import Scope, Task


class CancelScope(Scope):
    """A block that can be cancelled as a whole.

    Args:
        task: The task.
    """

    __slots__ = ()

    def __enter__(self) -> CancelScope:
        task = self.task
        self.outer = task.scope
        self.depth = task.depth = task.depth + 1
        task.scope = self
        self.is_open = True
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> bool:
        task = self.task
        task.scope = self.outer
        task.depth -= 1
        self.is_open = False
        if task.cancelled_depth != self.depth or not isinstance(error, asyncio.CancelledError):
            return False
        absorb_cancel(task)
        return True

    @property
    def is_cancelled(self) -> bool:
        """Whether it or a scope around it is cancelled, and has not been left."""
        return 0 <= self.task.cancelled_depth <= self.depth

    @property
    def is_cancelled_itself(self) -> bool:
        """Whether a `CancelledError` that arrives in it now ends with it."""
        return self.task.cancelled_depth == self.depth

    @property
    def tasks(self) -> list[Task]:
        """Live tasks started in it, directly or indirectly, in order of starts."""
        return self.task.descendants(self.depth)

    def cancel(self, outcome: Any) -> None:
        """Cancel it, unless it has been left. Call at commit.

        Args:
            outcome: Its outcome, unless it was cancelled before.
        """
        if not self.is_open:
            return
        if self.outcome is None:
            self.outcome = outcome
        _cancel(self.task, self.depth)

    def cancel_at_commit(self, path: tuple[int, ...], outcome: Any) -> None:
        """Cancel it between this delta cycle and the next, unless a scope around it is cancelled before.

        Args:
            path: Position by which effects of one delta cycle are ordered.
            outcome: Its outcome from then on.
        """

        def cancel() -> None:
            if not self.is_cancelled:
                self.cancel(outcome)

        self.task.scheduler.at_commit(path, cancel)

    async def wait_cancelled(self) -> None:
        """Wait until it is cancelled."""
        await self.task.sleep_forever()


def cancel_task(task: Task) -> None:
    """Cancel a task, with all tasks started in it. Call at commit."""
    if task.alive:
        _cancel(task, 0)


def absorb_cancel(task: Task) -> None:
    """Clear the cancellation of a task that has reached its end."""
    task.cancelled_depth, task.cancel_delivered = -1, False


def _cancel(task: Task, depth: int) -> None:
    tasks, cause = task.descendants(depth), task.scheduler.cause
    if cause is not None:
        for cancelled in (task, *tasks):
            cancelled.past.cause = cause
    for descendant in tasks:
        descendant.cancelled_depth = 0
    if not 0 <= task.cancelled_depth <= depth:
        task.cancelled_depth = depth
    _cancel_in_turn([task, *tasks])


def _cancel_in_turn(tasks: list[Task]) -> None:
    """Cancel the last task, and continue with the others when it has ended."""
    while tasks:
        task = tasks.pop()
        if not task.alive or not task.is_cancelled:
            continue
        if tasks:
            task.when_ended(lambda _: _cancel_in_turn(tasks))
        if not task.cancel_delivered:
            task.cancel_delivered, task.cancelled_at, task.overran = True, time.monotonic(), False
            task.scheduler.deliver_cancel(task)
        return
