"""Invocation of a scenario (7.3.5.1.3): a new instance of it, and its `do` within a scope of its own.

Its arguments are evaluated when the invocation starts. `emit end` and `emit fail` inside end the scope, and cancel
what is still running in it. Its `start`, then its `end` or `fail` occur for whoever listens inside.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable
from dataclasses import replace

from seoro.lang.plan import Phase, Scenario
from seoro.runtime.behaviors.members import Perform
from seoro.runtime.invocation import Instance, Place
from seoro.runtime.verdict import SUCCEEDED, Outcome


def run_scenario(place: Place, perform: Perform) -> Awaitable[Outcome]:
    """Carry it out."""
    return run_instance(place.take_invoked(), place, perform)


async def run_instance(instance: Instance, place: Place, perform: Perform) -> Outcome:
    """Carry out a scenario that has been instantiated."""
    agenda, flow = place.agenda, place.flow
    declaration = instance.declaration
    assert isinstance(declaration, Scenario)
    body = declaration.body
    inside = replace(place, instance=instance, invoked=None)
    with agenda.scope(flow) as scope:
        instance.scope = scope
        place.services.coverage.watch(instance)
        place.services.events.emit(instance.phase(None, Phase.START), {}, flow.past)
        try:
            outcome = SUCCEEDED if body is None else await perform(body, inside.member(0, body))
            await agenda.step(flow)
        except asyncio.CancelledError:
            if not agenda.left(scope):
                raise
            assert scope.outcome is not None, "it was ended"
            outcome = scope.outcome
    phase = Phase.FAIL if outcome.failed else Phase.END
    place.services.events.emit(instance.phase(None, phase), {}, flow.past)
    return outcome
