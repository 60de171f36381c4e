"""`until` (7.6.2.5.4): a behavior ends exactly when an event occurs, neither before nor after.

- Its event context starts with the behavior; events that the behavior itself emits count.
- Adjacent directives form one: any of their events ends the behavior.
- 7.6.2.5.4 is silent on the rest. A behavior that has finished before the event holds until then. A failure before
  the event ends it at once; a behavior ended by the event takes no further step.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from functools import partial

from seoro.lang.plan import Until
from seoro.runtime.behaviors.limits import BoundedScope
from seoro.runtime.execution.context import Carry, ExecutionContext
from seoro.runtime.kernel.cancel_scope import CancelScope
from seoro.runtime.kernel.channel import Occurrence
from seoro.runtime.kernel.task import CausalPast
from seoro.runtime.verdict import SUCCEEDED, Outcome


async def run_until(directives: Sequence[Until], context: ExecutionContext, inner: Carry) -> Outcome:
    """Run a behavior until one of the events."""
    task, past, outcome = context.task, context.task.past.fork(), SUCCEEDED
    with BoundedScope(task) as scope, ExitStack() as subscriptions:
        if _subscribe(directives, context, past, scope, subscriptions):
            await task.step()  # cancelled before it begins
        outcome = await inner(context)
        await task.step()
        if not outcome.failed:
            with context.waiting(directives[0].span):
                await scope.wait_cancelled()
    task.past.join(past)
    return scope.outcome or outcome


def _subscribe(
    directives: Sequence[Until],
    context: ExecutionContext,
    past: CausalPast,
    scope: CancelScope,
    subscriptions: ExitStack,
) -> bool:
    """Subscribe to the events, the first of which ends the scope; return whether it has occurred already."""
    is_met = False

    def meet(_: Occurrence) -> bool:
        nonlocal is_met
        if is_met:
            return False
        is_met = True
        scope.cancel_at_commit(context.position, SUCCEEDED)
        return True

    for number, directive in enumerate(directives):
        purpose = partial(_purpose, context, number)
        subscriptions.enter_context(context.subscribe(directive.event, past, meet, purpose))
    return is_met


def _purpose(context: ExecutionContext, number: int) -> str:
    return f"{context.purpose()} until {number}"
