"""`serial` (7.3.13.1, 7.6.2.1): members one after another.

Each member starts in the instant in which its predecessor ended. It fails with its first failing member.
"""

from __future__ import annotations

from seoro.lang.plan import Serial
from seoro.runtime.behaviors.members import Perform
from seoro.runtime.place import Place
from seoro.runtime.verdict import SUCCEEDED, Outcome


async def run_serial(plan: Serial, place: Place, perform: Perform) -> Outcome:
    """Carry it out."""
    for index, member in enumerate(plan.members):
        outcome = await perform(member, place.member(index, member))
        if outcome.failed:
            break
    else:
        outcome = SUCCEEDED
    await place.agenda.step(place.flow)
    return outcome
