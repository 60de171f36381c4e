"""`parallel` (7.3.13.2, 7.6.2.1) with the default overlap: all members start in one instant.

It ends when all members have ended. It fails with the first failing member, and the others are cancelled then;
of members that fail in one round, the first in the text counts.
"""

from __future__ import annotations

from seoro.lang.plan import Parallel
from seoro.runtime.agenda import Flow
from seoro.runtime.behaviors.members import Perform, member_group
from seoro.runtime.invocation import Place
from seoro.runtime.verdict import SUCCEEDED, Outcome, Status


async def run_parallel(plan: Parallel, place: Place, perform: Perform) -> Outcome:
    """Carry it out."""
    outcome = SUCCEEDED

    def member_ended(flow: Flow) -> None:
        nonlocal outcome
        if flow.outcome is not None and flow.outcome.failed and not outcome.failed:
            outcome = flow.outcome
            for other in members.alive:
                place.agenda.end_flow(other, Outcome(Status.CANCELLED, "a parallel member failed"))

    async with member_group(place, perform, member_ended) as members:
        for index, member in enumerate(plan.members):
            members.start(index, member)
        await members.gather()
    await place.agenda.step(place.flow)
    return outcome
