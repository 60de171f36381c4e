"""Delta cycles: the steps of the present cycle and of the next, and the effects committed between them.

Contract: no task sees an effect of its own delta cycle. Effects are committed in this order, each kind by its
keys:
    changes of variables; checks of conditions on variables; cancellations; messages of channels; ends of
    subscriptions.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from functools import partial
from operator import itemgetter
from typing import Any, TypeAlias

from seoro.runtime.kernel.task import Task

StepOrder: TypeAlias = Callable[[tuple[int, ...]], Any]
"""Returns the sort key of a task's path in a delta cycle."""

Act: TypeAlias = Callable[[], None]

Effects: TypeAlias = list[tuple[Any, Act, int | None]]
"""Sort key, effect, and the cause of the effect (`CausalPast.cause`)."""


Step: TypeAlias = tuple[Any, Act, Task | None, bool]
"""Sort key, function that takes the step, resumed task or None, and whether the step runs alone.

A step that runs alone may take more than one turn of the event loop.
"""


class DeltaCycle:
    """Steps of the present delta cycle and of the next.

    Args:
        order: Order of steps in a cycle.
        cancel: Cancels a task.
    """

    __slots__ = ("_cancel", "_cancelling", "_steps", "has_next", "number", "order", "present")

    def __init__(self, order: StepOrder | None, cancel: Callable[[Task], None]) -> None:
        self.number = 0
        self.has_next = False  # whether the next cycle has any step
        self.order = order
        self._cancel = cancel
        self._cancelling: list[Task] = []
        self._steps: list[Step] = []
        self.present: deque[Step] = deque()  # remaining steps of the present cycle

    def add(
        self, path: tuple[int, ...], act: Callable[[], None], task: Task | None = None, alone: bool = False
    ) -> None:
        """Add a step to the next cycle."""
        self.has_next = True
        self._steps.append((path if self.order is None else self.order(path), act, task, alone))

    def cancel(self, task: Task) -> None:
        """Cancel a task in the next cycle, before all steps, in order of paths."""
        self.has_next = True
        self._cancelling.append(task)

    def begin(self) -> None:
        """Make the next cycle the present one."""
        self.number += 1
        self.has_next = False
        if self._cancelling:
            self._cancelling.sort(key=lambda task: task.path)
            for task in self._cancelling:
                self.present.append((None, partial(self._cancel, task), task, True))
            self._cancelling.clear()
        if len(self._steps) > 1:
            self._steps.sort(key=itemgetter(0))
        self.present.extend(self._steps)
        self._steps.clear()


class Commit:
    """Effects of a delta cycle with their sort keys.

    Args:
        failed: Called when an effect raises, which is a defect; the others are still committed.

    Attributes:
        cause: Cause of the effect that is being committed.
    """

    __slots__ = ("_failed", "cancellations", "cause", "checks", "closings", "sends", "writes")

    def __init__(self, failed: Callable[[Exception], None]) -> None:
        self._failed = failed
        self.cause: int | None = None
        self.writes: Effects = []
        self.checks: Effects = []
        self.cancellations: Effects = []
        self.sends: Effects = []
        self.closings: Effects = []

    @property
    def is_due(self) -> bool:
        """Whether any effect is pending."""
        return bool(self.writes or self.checks or self.cancellations or self.sends or self.closings)

    def run(self) -> None:
        """Commit all effects and their consequences; further changes of variables wait for the next commit."""
        if self.writes:
            writes, self.writes = self.writes, []
            self._call_in_order(writes)
        if self.checks:
            checks, self.checks = self.checks, []
            self._call_in_order(checks)
        while self.cancellations or self.sends:
            cancellations, self.cancellations = self.cancellations, []
            self._call_in_order(cancellations)
            if not self.cancellations:
                sends, self.sends = self.sends, []
                self._call_in_order(sends)
        if self.closings:
            closings, self.closings = self.closings, []
            self._call(closings)

    def _call_in_order(self, effects: Effects) -> None:
        if len(effects) > 1:
            effects.sort(key=itemgetter(0))
        self._call(effects)

    def _call(self, effects: Effects) -> None:
        for _, effect, cause in effects:
            self.cause = cause
            try:
                effect()
            except Exception as error:
                self._failed(error)
        self.cause = None
