"""Objects that actions wait for: reports of backends, and notifications of other actions."""

from __future__ import annotations

from typing import TYPE_CHECKING

from seoro.runtime.contracts.backends import Report
from seoro.runtime.kernel.scheduler import Scheduler
from seoro.runtime.kernel.task import Waiter

if TYPE_CHECKING:
    from seoro.runtime.execution.context import ExecutionContext


class Pending:
    """A future report of a backend."""

    def __init__(self) -> None:
        self.reported: Report | None = None
        self.waiter: tuple[ExecutionContext, Waiter] | None = None  # of the waiting action

    @property
    def settled(self) -> bool:
        """Whether the report has arrived."""
        return self.reported is not None

    def settle(self, report: Report) -> None:
        """Set the report. Called by backends."""
        self.reported = report
        if self.waiter is not None:
            context, waiter = self.waiter
            context.scheduler.wake_now(waiter)


class Notifier:
    """Repeated notification of waiting actions by other actions."""

    def __init__(self) -> None:
        self.waiting: list[tuple[Scheduler, Waiter]] = []

    def notify(self) -> None:
        """Resume the waiting actions, in the next delta cycle."""
        waiting, self.waiting = self.waiting, []
        for scheduler, waiter in waiting:
            scheduler.wake(waiter)
