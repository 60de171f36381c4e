"""Invocations (7.3.5.1.3): a new instance of a scenario or an action, with the values of its parameters.

Arguments are evaluated when the invocation starts, and its modifiers become instances then, too. The first
instance is there for what modifies the invocation; what carries that out again gets another one for each time.

An instance is carried out within a scope of its own: `emit end` and `emit fail` inside end the scope, and cancel
what is still running in it. Its `start`, then its `end` or `fail` occur for whoever listens inside; these do as
well when what belongs to its invocation ends it: its `duration` (7.3.10.3), `until`, a modifier.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable
from contextlib import ExitStack
from dataclasses import replace
from functools import partial
from typing import NamedTuple

from seoro.lang.plan import InvokeAction, InvokeScenario, Literal, OneOf, Parallel, Phase, Serial
from seoro.runtime.applied import Applied, Modifying, apply, with_nested
from seoro.runtime.behaviors.duration import times_of
from seoro.runtime.behaviors.members import Carry
from seoro.runtime.behaviors.reactions import arm_reactions
from seoro.runtime.behaviors.records import record_instance
from seoro.runtime.choose.fields import Fields
from seoro.runtime.choose.plain import is_given
from seoro.runtime.choose.times import DURATION
from seoro.runtime.environment import Environment
from seoro.runtime.evaluate import evaluate
from seoro.runtime.instances import Composed, Instance, Invoked
from seoro.runtime.instantiate import Invocation, choose_parameters, choose_times, take_given
from seoro.runtime.place import Place
from seoro.runtime.values import Actor, Value
from seoro.runtime.verdict import CANCELLED, Outcome, Status

OF_BLOCK, OF_TYPE = (-2,), (-1,)  # positions of what modifies a behavior, before its body, which is member 0


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
                _emit_end(instance, _outcome_from_around(place), place, armed)
                raise
            assert scope.outcome is not None, "it was ended"
            outcome = scope.outcome
        _emit_end(instance, outcome, place, armed)
    return outcome


def _outcome_from_around(place: Place) -> Outcome:
    """The outcome of what is ended from outside: cancelled, unless it is by what belongs to its invocation."""
    ended, invoked = place.flow.ended, place.invoked
    if ended is None or invoked is None or ended.depth <= invoked.depth or ended.outcome is None:
        return CANCELLED
    return ended.outcome


def _emit_end(
    instance: Instance | Composed, outcome: Outcome, place: Place, armed: ExitStack | None = None
) -> None:
    """Let an `end` or `fail` occur, which is the last that is reacted to."""
    if outcome.status is not Status.CANCELLED:
        _emit_phase(instance, Phase.FAIL if outcome.failed else Phase.END, place)
        if armed is not None:
            place.agenda.close(armed.pop_all().close)


def _emit_phase(instance: Instance | Composed, phase: Phase, place: Place) -> None:
    """Let a predefined event occur; that of a composition, which has no name, only if someone listens."""
    if isinstance(instance, Composed) and not instance.is_heard(phase):
        return
    place.services.events.emit(instance.phase(None, phase), {}, place.flow.past)


def run_composed(place: Place, carry: Carry) -> Awaitable[Outcome]:
    """Carry out what a composition does; its `start`, then its `end` or `fail` occur, where someone may listen."""
    return carry(place) if place.invoked is None else _run_composed(place, place.invoked.take(place), carry)


async def _run_composed(place: Place, composed: Instance | Composed, carry: Carry) -> Outcome:
    _emit_phase(composed, Phase.START, place)
    try:
        outcome = await carry(place.invoking(None))
    except asyncio.CancelledError:
        _emit_end(composed, _outcome_from_around(place), place)
        raise
    _emit_end(composed, outcome, place)
    return outcome


def begin_composition(plan: Serial | Parallel | OneOf, place: Place) -> Begun:
    """Make what stands for a composition in its `with:` block, and instances of its modifiers.

    Raises:
        EvaluationError: A value cannot be computed, or there are none that meet all constraints.
    """
    if not (plan.constraints or plan.modifications or plan.duration):
        return Begun(place, (), ())
    plans = place.services.plan
    first = Composed(place.path, Fields())
    modifying = apply(plan.modifications, plans.modifiers, place.environment({"it": first}), first, OF_BLOCK)
    applied = tuple(with_nested(modifying))

    def fill(composed: Composed, environment: Environment) -> None:
        times, seed, run = times_of(plan, environment), environment.seed, environment.run
        invocation = Invocation({}, None, plan.constraints, environment, seed, run, applied, times)
        choose_times(plans, composed, invocation)

    def make(again: Place) -> Composed:
        composed = Composed(again.path, Fields() if has_times else first.fields)
        for modifier in applied:
            modifier.turn_to(composed)
        if has_times:
            fill(composed, replace(place, path=again.path, runs=again.runs).environment())
        return composed

    fill(first, place.environment())
    has_times = bool(plan.constraints or first.windows)
    return Begun(place.invoking(Invoked(first, make, len(place.flow.scopes) - 1, True)), modifying, ())


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

    def make(again: Place) -> Instance:
        there = replace(outside, path=again.path, runs=again.runs)
        instance = _empty(plan, there)
        for modifier in applied:
            modifier.turn_to(instance)
        _fill(instance, plan, there, applied)
        return instance

    is_watched = bool(applied) and any(each.modifier.on or each.modifier.samples for each in applied)
    invoked = Invoked(first, make, len(place.flow.scopes) - 1, is_watched)
    return Begun(place.invoking(invoked), modifying, own)


def _modifiers(
    plan: InvokeScenario | InvokeAction, first: Instance, outside: Place
) -> tuple[tuple[Modifying, ...], tuple[Modifying, ...]]:
    """What modifies an invocation where it stands, and what modifies each invocation of what is invoked."""
    services = outside.services
    modifiers = services.plan.modifiers
    modifying: tuple[Modifying, ...] = ()
    own: tuple[Modifying, ...] = ()
    if plan.modifications:
        modifying = apply(plan.modifications, modifiers, outside.environment({"it": first}), first, OF_BLOCK)
    if first.declaration.modifiers:
        around = services.environment_of(first, outside.environment())
        own = apply(first.declaration.modifiers, modifiers, around, first, OF_TYPE)
    return modifying, own


def _empty(plan: InvokeScenario | InvokeAction, place: Place) -> Instance:
    """An instance without values."""
    plans = place.services.plan
    declared = plans.scenarios[plan.scenario] if isinstance(plan, InvokeScenario) else plans.actions[plan.action]
    actor = evaluate(plan.actor, place.environment()) if plan.actor is not None else None
    assert actor is None or isinstance(actor, Actor)
    return Instance(place.path, Fields(), declared, {"actor": actor} if actor is not None else {})


def _fill(
    instance: Instance, plan: InvokeScenario | InvokeAction, place: Place, applied: tuple[Applied, ...]
) -> None:
    """Give an instance its values, and modifiers that have none yet theirs."""
    services = place.services
    environment: Environment | None = None  # nearly all arguments are constants, which need none
    given: dict[str, Value] = {}
    for name, argument in plan.arguments:
        if isinstance(argument, Literal):
            given[name] = argument.value
        else:
            environment = environment or place.environment()
            given[name] = evaluate(argument, environment)
    structure, of_globals = instance.declaration.structure, services.plan.globals.fields
    shared = {name: place.instance.fields[name] for name in of_globals} if of_globals else {}
    if not (applied or plan.constraints or plan.duration) and is_given(structure, given):
        take_given(instance.fields, given, shared)  # so it is with nearly all; the rest is for the others
    else:
        environment = environment or place.environment()
        seed, run = environment.seed, environment.run
        times = times_of(plan, environment) if DURATION not in structure.fields else None
        invocation = Invocation(given, instance.actor, plan.constraints, environment, seed, run, applied, times)
        choose_parameters(services.plan, structure, instance, invocation, shared)
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
