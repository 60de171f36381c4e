"""`one_of` (7.3.13.3, 7.6.2.1): exactly one of the members.

- Members that begin with a `wait` are guarded. One unguarded member is drawn from the seed and invoked; the guards
  of all guarded members are armed beside it. The first event decides, and cancels everything else: either the
  invoked member ends, or a guard is over and its member continues.
- Events of one instant have no order: of guards that are over in it, the first in the text wins, and a member that
  ends in it has ended before. A guard therefore decides when the instant has otherwise settled.
- If the invoked member fails, the guarded ones stay armed; without guarded members, the next unguarded one is
  drawn.
- An invoked member that `override` ends is chosen; a member that `override` prevents from starting, or ends before
  its guard is over, is not.
"""

from __future__ import annotations

from seoro.lang.plan import OneOf
from seoro.runtime.behaviors.choice import Choice
from seoro.runtime.execution.context import ExecutionContext, PerformMember
from seoro.runtime.kernel.task_group import TaskGroup
from seoro.runtime.verdict import Outcome


async def run_one_of(plan: OneOf, context: ExecutionContext, perform: PerformMember) -> Outcome:
    """Run one of the members."""
    choice = Choice(plan, context.services.random(context.purpose()))
    async with TaskGroup(context.task, choice) as group:
        choice.group = group
        for index, path, member in choice.guarded(context.position):
            group.start_soon(perform, member, index, context, path=path, guarded=True)
        while (drawn := choice.draw()) is not None:
            member = plan.members[drawn]
            group.start_soon(perform, member, drawn, context, path=(*context.position, drawn))
            await group.join()
    await context.task.step()
    return choice.outcome
