"""`BehaviorScope`: the scope of a running behavior; explanations read the current activities from it."""

from __future__ import annotations

from seoro.lang.plan import Behavior
from seoro.runtime.execution.context import ExecutionContext
from seoro.runtime.kernel.cancel_scope import CancelScope
from seoro.runtime.kernel.task import Task


class BehaviorScope(CancelScope):
    """Scope of a behavior.

    Args:
        behavior: The behavior.
        context: Its context.
    """

    __slots__ = ("behavior", "context", "since")

    def __init__(self, behavior: Behavior, context: ExecutionContext) -> None:
        self.task = context.task  # without `super`, to save time for each behavior
        self.outcome = None
        self.behavior = behavior
        self.context = context
        self.since = context.services.scheduler.now  # [s]


def behaviors_of(task: Task) -> list[BehaviorScope]:
    """Return the running behaviors of a task, the innermost first."""
    found: list[BehaviorScope] = []
    scope = task.scope
    while scope is not None and scope.task is task:
        if isinstance(scope, BehaviorScope):
            found.append(scope)
        scope = scope.outer
    return found
