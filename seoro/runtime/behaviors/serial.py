"""`serial` (7.3.13.1, 7.6.2.1): members one after another.

- Each member starts in the instant in which its predecessor ended.
- It fails with its first failing member.
"""

from __future__ import annotations

from seoro.lang.plan import Serial
from seoro.runtime.execution.context import ExecutionContext, Perform
from seoro.runtime.verdict import SUCCEEDED, Outcome


async def run_serial(plan: Serial, context: ExecutionContext, perform: Perform) -> Outcome:
    """Run the members one after another."""
    for index, member in enumerate(plan.members):
        outcome = await perform(member, context.member(index, member))
        if outcome.failed:
            break
    else:
        outcome = SUCCEEDED
    await context.task.step()
    return outcome
