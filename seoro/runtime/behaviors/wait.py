"""`wait` (7.3.10.4, 7.6.2.5): holds up its flow until the event specification is met.

Its event context starts with it. An event counts from that instant on, unless it is in the flow's past.
"""

from __future__ import annotations

from seoro.lang.plan import Elapsed, EventSpecification, Wait
from seoro.runtime.agenda import Waiter
from seoro.runtime.conditions import Context, Stop
from seoro.runtime.events import Occurrence
from seoro.runtime.listening import Listener
from seoro.runtime.place import Place
from seoro.runtime.verdict import SUCCEEDED, Outcome


async def run_wait(plan: Wait, place: Place) -> Outcome:
    """Carry it out."""
    services, flow = place.services, place.flow
    waiter = Waiter(flow)
    context = Context(services.agenda.now, flow.past, place.position, place.purpose)
    stop: Stop | None = None
    if isinstance(plan.event, Elapsed):
        services.conditions.fire_after(plan.event, place.environment(), context, waiter)
    else:
        stop = _listen(plan.event, waiter, context, place)
    services.waits[flow] = plan.span
    try:
        await services.agenda.wait(waiter)
    finally:
        del services.waits[flow]
        if stop is not None:
            stop()
    return SUCCEEDED


def _listen(event: EventSpecification, waiter: Waiter, context: Context, place: Place) -> Stop:
    """Fire a waiter when an event specification is met; returns what stops that."""
    agenda = place.agenda

    def meet(_: Occurrence) -> bool:
        if waiter.fired:
            return False
        agenda.fire(waiter)
        return True

    return Listener(place.services, context).listen(event, place.environment(), meet)
