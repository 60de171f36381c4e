"""Invocations (7.3.5.1.3): a new instance of a scenario or an action, with the values of its parameters.

Arguments are evaluated when the invocation starts. The first instance is there for what modifies the invocation;
what carries the invocation out again gets another one for each time.

An instance is carried out within a scope of its own: `emit end` and `emit fail` inside end the scope, and cancel
what is still running in it. Its `start`, then its `end` or `fail` occur for whoever listens inside.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable
from contextlib import ExitStack
from dataclasses import replace
from functools import partial

from seoro.lang.plan import InvokeAction, InvokeScenario, Phase
from seoro.runtime.behaviors.members import Carry
from seoro.runtime.behaviors.reactions import arm_reactions
from seoro.runtime.evaluate import evaluate
from seoro.runtime.instantiate import Invocation, parameters
from seoro.runtime.invocation import Instance, Invoked, Place
from seoro.runtime.values import Actor, Value
from seoro.runtime.verdict import Outcome


def run_invocation(plan: InvokeScenario | InvokeAction, place: Place, inner: Carry) -> Awaitable[Outcome]:
    """Carry out what is invoked, and what modifies it, with instances of it."""
    make = partial(_instantiate, plan, replace(place, invoked=None))
    return inner(replace(place, invoked=Invoked(make)))


async def run_instance(instance: Instance, place: Place, carry: Carry) -> Outcome:
    """Carry out an instance, which reacts to events meanwhile.

    Args:
        instance: The instance.
        place: Of its invocation.
        carry: Carries out what it does.
    """
    agenda, flow = place.agenda, place.flow
    inside = replace(place, instance=instance, invoked=None)
    with agenda.scope(flow) as scope, ExitStack() as armed:
        instance.scope = scope
        reactions = arm_reactions(inside, scope, armed)
        _emit_phase(instance, Phase.START, place)
        try:
            outcome = await carry(inside)
            await agenda.step(flow)
        except asyncio.CancelledError:
            if not agenda.left(scope):
                reactions.abandon()
                raise
            assert scope.outcome is not None, "it was ended"
            outcome = scope.outcome
        reacting = armed.pop_all()
    _emit_phase(instance, Phase.FAIL if outcome.failed else Phase.END, place)
    agenda.emit(reacting.close)  # after its end, which is the last that it reacts to
    return outcome


def _emit_phase(instance: Instance, phase: Phase, place: Place) -> None:
    place.services.events.emit(instance.phase(None, phase), {}, place.flow.past)


def _instantiate(plan: InvokeScenario | InvokeAction, place: Place) -> Instance:
    services = place.services
    declared = (
        services.plan.scenarios[plan.scenario]
        if isinstance(plan, InvokeScenario)
        else services.plan.actions[plan.action]
    )
    invocation = _invoked(plan, place)
    shared = {name: place.instance.fields[name] for name in services.plan.globals.fields}
    fields = parameters(services.plan, declared, invocation, shared)
    instance = Instance(declared, place.path, fields, invocation.actor)
    for value in instance.fields.values():
        if isinstance(value, Actor) and services.homes.of(value) is None:
            services.homes.settle(value)
    if plan.label is not None:
        services.agenda.write(place.position, partial(_take_label, plan.label, instance, place))
    return instance


def _take_label(label: str, instance: Instance, place: Place) -> None:
    """Let a label stand for a new instance, for those who listen and for conditions that have read it."""
    place.instance.latest(label).take(instance)
    place.services.conditions.changed(place.instance, label)


def _invoked(plan: InvokeScenario | InvokeAction, place: Place) -> Invocation:
    """What an invocation says, with the values that its expressions have now."""
    environment = place.environment()
    actor = evaluate(plan.actor, environment) if plan.actor is not None else None
    assert actor is None or isinstance(actor, Actor)
    given: dict[str, Value] = {name: evaluate(value, environment) for name, value in plan.arguments}
    return Invocation(given, actor, plan.constraints, environment, environment.seed, environment.run)
