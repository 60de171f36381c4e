"""`wait` (7.3.10.4, 7.6.2.5): suspends its task until the event specification is met.

- Its event context starts with it: an event counts from that instant on, unless it is in the task's past.
"""

from __future__ import annotations

from seoro.lang.plan import Elapsed, Wait
from seoro.runtime.execution.context import ExecutionContext
from seoro.runtime.verdict import SUCCEEDED, Outcome


async def run_wait(plan: Wait, context: ExecutionContext) -> Outcome:
    """Wait for one occurrence, or until a time has elapsed."""
    if isinstance(plan.event, Elapsed):
        end = context.end_of(plan.event)
        with context.waiting(plan.span):
            await context.task.sleep_until(end)
    else:
        with context.subscribe(plan.event) as subscription, context.waiting(plan.span):
            await subscription.receive()
    return SUCCEEDED
