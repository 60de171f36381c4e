"""Invocation of a scenario (7.3.5.1.3): a new instance of it, and its `do` within a scope of its own.

Its arguments are evaluated when the invocation starts. `emit end` and `emit fail` inside end the scope, and cancel
what is still running in it. Its `start`, then its `end` or `fail` occur for whoever listens inside.
"""

from __future__ import annotations

import asyncio
from dataclasses import replace

from seoro.lang.plan import InvokeAction, InvokeScenario, Phase, Scenario
from seoro.runtime.behaviors.members import Perform
from seoro.runtime.evaluate import evaluate
from seoro.runtime.instantiate import Invocation, parameters
from seoro.runtime.invocation import Instance, Place
from seoro.runtime.values import Actor, Value
from seoro.runtime.verdict import SUCCEEDED, Outcome


async def run_scenario(plan: InvokeScenario, place: Place, perform: Perform) -> Outcome:
    """Carry it out."""
    scenario = place.services.plan.scenarios[plan.scenario]
    invocation = invoked(plan, place)
    fields = parameters(place.services.plan, scenario, invocation, shared(place))
    instance = Instance(scenario, place.path, fields, invocation.actor)
    for value in instance.fields.values():
        if isinstance(value, Actor) and place.services.homes.of(value) is None:
            place.services.homes.settle(value)
    return await run_instance(instance, place, perform)


async def run_instance(instance: Instance, place: Place, perform: Perform) -> Outcome:
    """Carry out a scenario that has been instantiated."""
    agenda, flow = place.agenda, place.flow
    declaration = instance.declaration
    assert isinstance(declaration, Scenario)
    body = declaration.body
    inside = replace(place, instance=instance)
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


def invoked(plan: InvokeScenario | InvokeAction, place: Place) -> Invocation:
    """What an invocation says, with the values that its expressions have now."""
    environment = place.environment()
    actor = evaluate(plan.actor, environment) if plan.actor is not None else None
    assert actor is None or isinstance(actor, Actor)
    given = {name: evaluate(value, environment) for name, value in plan.arguments}
    return Invocation(given, actor, plan.constraints, environment, environment.seed, environment.run)


def shared(place: Place) -> dict[str, Value]:
    """The values of the global parameters."""
    return {name: place.instance.fields[name] for name in place.services.plan.globals.fields}
