"""`until` (7.6.2.5.4): a behavior ends exactly when the event occurs, not before or after.

Its event context starts with the behavior; what that itself emits counts. The directives that stand in a row are
one, which any of their events meets. Where 7.6.2.5.4 is silent: what has finished its work before the event
holds until then; what fails before the event ends at once; what the event ends takes no further step.
"""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from contextlib import ExitStack

from seoro.lang.plan import Until
from seoro.runtime.agenda import Scope, Waiter
from seoro.runtime.behaviors.members import Carry
from seoro.runtime.conditions import Context
from seoro.runtime.events import Occurrence
from seoro.runtime.listening import Listener
from seoro.runtime.past import Past
from seoro.runtime.place import Place
from seoro.runtime.verdict import SUCCEEDED, Outcome


async def run_until(directives: Sequence[Until], place: Place, inner: Carry) -> Outcome:
    """Carry out a behavior until one of some events."""
    agenda, flow = place.agenda, place.flow
    past = flow.past.fork()
    with agenda.scope(flow) as scope:
        scope.has_end = True
        try:
            with ExitStack() as armed:
                if _arm(directives, place, past, scope, armed):
                    await agenda.step(flow)  # to be ended before it begins
                outcome = await inner(place)
                await agenda.step(flow)
                if not outcome.failed:
                    await _hold(directives, place)
        except asyncio.CancelledError:
            if not agenda.left(scope):
                raise
            assert scope.outcome is not None, "it was ended"
            outcome = scope.outcome
    flow.past.join(past, agenda.instant)
    return outcome


def _arm(directives: Sequence[Until], place: Place, past: Past, scope: Scope, armed: ExitStack) -> bool:
    """Listen for the events; says whether one has occurred already."""
    agenda = place.agenda
    is_met = False

    def meet(_: Occurrence) -> bool:
        nonlocal is_met
        if is_met:
            return False
        is_met = True
        agenda.after_round(place.position, end)
        return True

    def end() -> None:
        if not agenda.is_ended(scope):
            agenda.end(scope, SUCCEEDED)

    for number, directive in enumerate(directives):
        purpose = f"{place.purpose} until {number}"
        listener = Listener(place.services, Context(agenda.now, past, place.position, purpose))
        armed.callback(listener.listen(directive.event, place.environment(), meet))
    return is_met


async def _hold(directives: Sequence[Until], place: Place) -> None:
    """Wait for the event that ends this."""
    place.services.waits[place.flow] = directives[0].span
    try:
        await place.agenda.wait(Waiter(place.flow))
    finally:
        del place.services.waits[place.flow]
