"""Invocation of a scenario (7.3.5.1.3): a new instance of it, and its `do` within a scope of its own.

Its arguments are evaluated when the invocation starts. `emit end` and `emit fail` inside end the scope, and cancel
what is still running in it. Its `start`, then its `end` or `fail` occur for whoever listens inside.
"""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, replace

from seoro.lang.plan import InvokeScenario, Phase, Plan, Scenario
from seoro.runtime.behaviors.members import Perform
from seoro.runtime.evaluate import Environment, evaluate
from seoro.runtime.invocation import Instance, Place
from seoro.runtime.values import Actor, Value
from seoro.runtime.verdict import SUCCEEDED, Outcome


async def run_scenario(plan: InvokeScenario, place: Place, perform: Perform) -> Outcome:
    """Carry it out."""
    environment = place.environment()
    actor = evaluate(plan.actor, environment) if plan.actor is not None else None
    assert actor is None or isinstance(actor, Actor)
    given = {name: evaluate(value, environment) for name, value in plan.arguments}
    shared = {found.name: place.instance.fields[found.name] for found in place.services.plan.globals}
    scenario = place.services.plan.scenarios[plan.scenario]
    instance = instantiate(scenario, place.path, {**shared, **given}, actor)
    for value in instance.fields.values():
        if isinstance(value, Actor) and place.services.homes.of(value) is None:
            place.services.homes.settle(value)
    return await run_instance(instance, place, perform)


async def run_instance(instance: Instance, place: Place, perform: Perform) -> Outcome:
    """Carry out a scenario that has been instantiated."""
    agenda, flow = place.agenda, place.flow
    body = instance.scenario.body
    inside = replace(place, instance=instance)
    with agenda.scope(flow) as scope:
        instance.scope = scope
        place.services.events.emit(instance.phase(None, Phase.START), {}, flow)
        try:
            outcome = SUCCEEDED if body is None else await perform(body, inside.member(0, body))
            await agenda.step(flow)
        except asyncio.CancelledError:
            if not agenda.left(scope):
                raise
            assert scope.outcome is not None, "it was ended"
            outcome = scope.outcome
    phase = Phase.FAIL if outcome.failed else Phase.END
    place.services.events.emit(instance.phase(None, phase), {}, flow)
    return outcome


@dataclass(frozen=True)
class _Parameters:
    """The parameters of an instance while they get their values, one after another."""

    scenario: Scenario
    fields: dict[str, Value]


def evaluate_globals(plan: Plan) -> dict[str, Value]:
    """The values of the global parameters of a run (7.3.14).

    Raises:
        EvaluationError: A value cannot be computed.
    """
    found = _Parameters(plan.scenarios[plan.entry], {})
    for parameter in plan.globals:
        assert parameter.value is not None, "checked: it has a value"
        path = parameter.name.rpartition("::")[2]
        found.fields[parameter.name] = evaluate(parameter.value, Environment(found, {}, path))
    return found.fields


def instantiate(scenario: Scenario, path: str, given: dict[str, Value], actor: Actor | None) -> Instance:
    """A new instance; parameters that were not given take the values of the plan, in their order.

    Args:
        scenario: What to instantiate.
        path: Its position, for people.
        given: Values of parameters, and of all global parameters.
        actor: The actor that it is invoked on.

    Raises:
        EvaluationError: A value cannot be computed.
    """
    parameters = _Parameters(scenario, dict(given))
    bindings = {"actor": actor} if actor is not None else {}
    for parameter in scenario.parameters:
        if parameter.name not in parameters.fields:
            assert parameter.value is not None, "checked: the invocation gives it, or it has a value"
            environment = Environment(parameters, bindings, parameter.name)
            parameters.fields[parameter.name] = evaluate(parameter.value, environment)
    return Instance(scenario, path, parameters.fields, actor)
