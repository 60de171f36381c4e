"""`wait` (7.3.10.4, 7.6.2.5): holds up its flow until the event specification is met.

Its event context starts with it. An event counts from that instant on, unless it is in the flow's past.
"""

from __future__ import annotations

from seoro.lang.plan import Wait
from seoro.runtime.agenda import Waiter
from seoro.runtime.conditions import Context
from seoro.runtime.events import Occurrence
from seoro.runtime.invocation import Place
from seoro.runtime.listening import Listener
from seoro.runtime.verdict import SUCCEEDED, Outcome


async def run_wait(plan: Wait, place: Place) -> Outcome:
    """Carry it out."""
    agenda, waiter = place.agenda, Waiter(place.flow)

    def meet(_: Occurrence) -> bool:
        if waiter.fired:
            return False
        agenda.fire(waiter)
        return True

    context = Context(agenda.now, place.flow.past, place.position, place.purpose)
    stop = Listener(place.services, context).listen(plan.event, place.environment(), meet)
    place.services.waits[place.flow] = plan.span
    try:
        await agenda.wait(waiter)
    finally:
        del place.services.waits[place.flow]
        stop()
    return SUCCEEDED
