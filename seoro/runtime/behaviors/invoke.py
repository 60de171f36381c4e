"""Invocations (7.3.5.1.3): a new instance of a scenario or an action, with the values of its parameters.

Arguments are evaluated when the invocation starts, and its modifiers become instances then, too. The first
instance is there for what modifies the invocation; what carries that out again gets another one for each time.

An instance is carried out within a scope of its own: `emit end` and `emit fail` inside end the scope, and cancel
what is still running in it. Its `start`, then its `end` or `fail` occur for whoever listens inside.
"""

from __future__ import annotations

import asyncio
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from typing import NamedTuple

from seoro.lang.plan import InvokeAction, InvokeScenario, OneOf, Parallel, Phase, Serial
from seoro.runtime.applied import Applied, Modifying, apply, with_nested
from seoro.runtime.behaviors.members import Carry
from seoro.runtime.behaviors.reactions import arm_reactions
from seoro.runtime.behaviors.records import record_instance
from seoro.runtime.choose.fields import Fields
from seoro.runtime.evaluate import evaluate
from seoro.runtime.instantiate import Invocation, choose_for_modifiers, choose_parameters
from seoro.runtime.invocation import Instance, Invoked, Place
from seoro.runtime.values import Actor, Value
from seoro.runtime.verdict import Outcome


class Begun(NamedTuple):
    """A behavior that is about to be carried out.

    Args:
        place: Its place, with what is invoked there.
        modifying: What modifies it where it stands, the outermost first.
        own: What modifies each invocation of what is invoked.
    """

    place: Place
    modifying: tuple[Modifying, ...]
    own: tuple[Modifying, ...]


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
    agenda.close(reacting.close)  # after its end, which is the last that it reacts to
    return outcome


def _emit_phase(instance: Instance, phase: Phase, place: Place) -> None:
    place.services.events.emit(instance.phase(None, phase), {}, place.flow.past)


def begin_composition(plan: Serial | Parallel | OneOf, place: Place) -> Begun:
    """Make instances of the modifiers of a composition.

    Raises:
        EvaluationError: A value cannot be computed, or there are none that meet all constraints.
    """
    if not plan.modifications:
        return Begun(place, (), ())
    environment = place.environment()
    modifying = apply(plan.modifications, place.services.plan, environment, None)
    applied = tuple(with_nested(modifying))
    if applied:
        seed, run = environment.seed, environment.run
        choose_for_modifiers(place.services.plan, Invocation({}, None, (), environment, seed, run, applied))
    return Begun(place, modifying, ())


def begin_invocation(plan: InvokeScenario | InvokeAction, place: Place) -> Begun:
    """Make an instance of what is invoked, and of the modifiers.

    Raises:
        EvaluationError: A value cannot be computed, or there are none that meet all constraints.
    """
    outside = place if place.invoked is None else place.invoking(None)
    first = _empty(plan, outside)
    modifying, own = _modifiers(plan, first, outside)
    applied = tuple(with_nested((*modifying, *own))) if modifying or own else ()
    _fill(first, plan, outside, applied)

    def make(path: str) -> Instance:
        again = replace(outside, path=path)
        instance = _empty(plan, again)
        for modifier in applied:
            modifier.turn_to(instance)
        _fill(instance, plan, again, applied)
        return instance

    return Begun(place.invoking(Invoked(first, make)), modifying, own)


def _modifiers(
    plan: InvokeScenario | InvokeAction, first: Instance, outside: Place
) -> tuple[tuple[Modifying, ...], tuple[Modifying, ...]]:
    """What modifies an invocation where it stands, and what modifies each invocation of what is invoked."""
    services = outside.services
    modifying: tuple[Modifying, ...] = ()
    own: tuple[Modifying, ...] = ()
    if plan.modifications:
        modifying = apply(plan.modifications, services.plan, outside.environment({"it": first}), first)
    if first.declaration.modifiers:
        around = services.environment_of(first, outside.environment())
        own = apply(first.declaration.modifiers, services.plan, around, first)
    return modifying, own


def _empty(plan: InvokeScenario | InvokeAction, place: Place) -> Instance:
    """An instance without values."""
    plans = place.services.plan
    declared = plans.scenarios[plan.scenario] if isinstance(plan, InvokeScenario) else plans.actions[plan.action]
    actor = evaluate(plan.actor, place.environment()) if plan.actor is not None else None
    assert actor is None or isinstance(actor, Actor)
    return Instance(declared, place.path, Fields(), actor)


def _fill(
    instance: Instance, plan: InvokeScenario | InvokeAction, place: Place, applied: tuple[Applied, ...]
) -> None:
    """Give an instance its values, and modifiers that have none yet theirs."""
    services, environment = place.services, place.environment()
    given: dict[str, Value] = {name: evaluate(value, environment) for name, value in plan.arguments}
    seed, run = environment.seed, environment.run
    invocation = Invocation(given, instance.actor, plan.constraints, environment, seed, run, applied)
    shared = {name: place.instance.fields[name] for name in services.plan.globals.fields}
    choose_parameters(services.plan, instance.declaration.structure, instance, invocation, shared)
    for value in instance.fields.values():
        if isinstance(value, Actor) and services.homes.of(value) is None:
            services.homes.settle(value)
    if plan.label is not None:
        services.agenda.write(place.position, partial(_take_label, plan.label, instance, place))
    record_instance(instance, place.parent, services)


def _take_label(label: str, instance: Instance, place: Place) -> None:
    """Let a label stand for a new instance, for those who listen and for conditions that have read it."""
    place.instance.latest(label).take(instance)
    place.services.conditions.changed(place.instance, label)
