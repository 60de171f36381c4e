"""Time limits of behaviors, and open-ended behaviors.

- A limit acts when the instant has otherwise settled: a behavior that ends in that instant is in time.
- Open-ended behaviors (an action marked so, a modifier that holds) are meant to be ended from outside.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Collection, Sequence

from seoro.runtime.execution.context import ExecutionContext
from seoro.runtime.kernel.cancel_scope import CancelScope
from seoro.runtime.kernel.task import Scope, Task
from seoro.runtime.kernel.timers import Deadline
from seoro.runtime.verdict import Outcome, Status

_CUT_OFF = Outcome(Status.CANCELLED, "it reached its limit")


class BoundedScope(CancelScope):
    """Scope that the scenario ends, for example by `until`."""

    __slots__ = ()


async def within_limit(
    context: ExecutionContext,
    limit: float,
    behave: Callable[[], Awaitable[Outcome]],
    judge: Callable[[CancelScope], Outcome] = lambda scope: _CUT_OFF,
    scope_type: type[CancelScope] = CancelScope,
) -> tuple[Outcome, bool]:
    """Run a behavior, and cancel it at a time limit.

    Args:
        context: Its context.
        limit: Time limit [s].
        behave: Runs the behavior.
        judge: Returns the outcome at the limit, given the scope.
        scope_type: Type of its scope.

    Returns:
        The outcome, and whether the limit cancelled the behavior.
    """
    scheduler = context.scheduler
    with scope_type(context.task) as scope:
        reached = Deadline(scope, lambda: scope.cancel(_explained(judge(scope), context, scope)))
        scheduler.act_at(scheduler.now + limit, reached)
        try:
            return await behave(), False
        finally:
            reached.over = True
    outcome: Outcome = scope.outcome
    return outcome, True


def _explained(outcome: Outcome, context: ExecutionContext, scope: CancelScope) -> Outcome:
    """Explain an outcome at the limit, unless it is a success."""
    return outcome if outcome.status is Status.SUCCEEDED else context.explained(outcome, scope)


def is_open_ended(tasks: Sequence[Task], outermost: Scope | None, open_ended: Collection[Task]) -> bool:
    """Whether any behavior that runs in the tasks is open-ended.

    Args:
        tasks: The tasks.
        outermost: Scope in which they run; surrounding scopes do not count.
        open_ended: Tasks that run an open-ended behavior.
    """
    return any(_is_endless(task, outermost, open_ended) for task in _innermost(tasks))


def is_all_open_ended(tasks: Sequence[Task], outermost: Scope | None, open_ended: Collection[Task]) -> bool:
    """Whether all behaviors that run in the tasks are open-ended; see `is_open_ended`."""
    return all(_is_endless(task, outermost, open_ended) for task in _innermost(tasks))


def _innermost(tasks: Sequence[Task]) -> list[Task]:
    """Return the tasks that do not wait for other tasks of the list."""
    parents = {task.parent for task in tasks[1:]}
    return [task for task in tasks if task not in parents]


def _is_endless(task: Task, outermost: Scope | None, open_ended: Collection[Task]) -> bool:
    """Whether a task runs an open-ended behavior, without a scope around it that will end it."""
    if task not in open_ended:
        return False
    scope = task.scope
    while scope is not None and scope is not outermost:
        if isinstance(scope, BoundedScope):
            return False
        scope = scope.outer
    return True
