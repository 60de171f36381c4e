"""`parallel` (7.3.13.2, 7.6.2.1.4): members that overlap.

- It ends when all members have ended. The first failing member fails it and cancels the others; of members that
  fail in one delta cycle, the first in the text counts.
- It also fails if members violate its timing arguments, or if they never all run in one instant
  (`overlap.py`).
"""

from __future__ import annotations

from seoro.lang.plan import Parallel
from seoro.runtime.behaviors.overlap import overlap_in
from seoro.runtime.behaviors.timing import Timing
from seoro.runtime.execution.context import ExecutionContext, PerformMember
from seoro.runtime.kernel.task_group import TaskGroup
from seoro.runtime.verdict import Outcome


async def run_parallel(
    plan: Parallel, timing: Timing, context: ExecutionContext, perform: PerformMember
) -> Outcome:
    """Run the members at their times, and judge how they overlap."""
    policy = overlap_in(context, plan, timing)
    async with TaskGroup(context.task, policy) as group:
        policy.group = group
        for start, indices in policy.starts(context.scheduler.now):
            await group.wait_until(start)  # ends early when the policy has failed
            if policy.failed:
                break
            for index in indices:
                member = plan.members[index]
                group.start_soon(perform, member, index, context, path=(*context.position, index))
    await context.task.step()
    return policy.outcome
