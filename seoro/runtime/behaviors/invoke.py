"""Invocations (7.3.5.1.3): a new instance of a scenario or an action, with values for its parameters.

Arguments are evaluated and modifiers become instances at the start of an invocation. Modifiers see the first
instance before it runs; each repetition of the invocation gets another instance.

An instance runs within a scope of its own: `emit end` and `emit fail` inside end the scope, and cancel everything
that still runs in it. Its events `start`, then `end` or `fail` occur for subscribers inside; they also occur when
its own `duration` (7.3.10.3), `until` or modifiers end it.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable
from contextlib import ExitStack
from functools import partial
from typing import TypeAlias

from seoro.lang.plan import InvokeAction, InvokeScenario, Literal, OneOf, Parallel, Phase, Serial
from seoro.runtime.behaviors.reactions import Reactions
from seoro.runtime.behaviors.records import record_instance
from seoro.runtime.behaviors.timing import times_of
from seoro.runtime.choose.plain import is_given
from seoro.runtime.execution.context import Carry, ExecutionContext, Invoked
from seoro.runtime.expressions.evaluation import evaluate
from seoro.runtime.instances.applied import OF_BLOCK, OF_TYPE, Applied, Modifying, apply, with_nested
from seoro.runtime.instances.instances import Composed, Instance
from seoro.runtime.instances.times import DURATION
from seoro.runtime.kernel.cancel_scope import CancelScope
from seoro.runtime.parameters.parameters import Invocation, choose_parameters, take_given
from seoro.runtime.values.environment import Environment
from seoro.runtime.values.values import Actor, Fields, Value
from seoro.runtime.verdict import CANCELLED, Outcome, Status

Begun: TypeAlias = tuple[ExecutionContext, tuple[Modifying, ...], tuple[Modifying, ...]]
# Context of a behavior that is ready to run, with the invoked instance; modifications of this invocation, the
# outermost first; modifications of the invoked type.


async def run_instance(instance: Instance, context: ExecutionContext, carry: Carry) -> Outcome:
    """Run an instance with its reactions.

    Args:
        instance: The instance.
        context: Context of its invocation.
        carry: Runs its body.
    """
    inside, outcome = context.of_instance(instance), CANCELLED
    with ExitStack() as armed:
        with CancelScope(context.task) as scope:
            instance.scope = scope
            reactions = Reactions(inside, scope, armed)
            _emit_phase(instance, Phase.START, context)
            try:
                outcome = await carry(inside)
                await context.task.step()
            except asyncio.CancelledError:
                if not scope.is_cancelled_itself:
                    reactions.abandon()
                    _emit_end(instance, _outcome_from_around(context), context, armed)
                raise
        outcome = scope.outcome or outcome
        _emit_end(instance, outcome, context, armed)
    return outcome


def _outcome_from_around(context: ExecutionContext) -> Outcome:
    """Return the outcome of a cancelled instance: that of its invocation's own limit, if this ended it."""
    task, invoked = context.task, context.invoked
    if invoked is None or task.cancelled_depth <= invoked.depth:
        return CANCELLED
    scope = task.scope
    while scope is not None and scope.depth > task.cancelled_depth:
        scope = scope.outer
    outcome: Outcome | None = scope.outcome if scope is not None else None
    return CANCELLED if outcome is None else outcome


def _emit_end(
    instance: Instance | Composed, outcome: Outcome, context: ExecutionContext, armed: ExitStack | None = None
) -> None:
    """Emit `end` or `fail`, the last event that the instance reacts to."""
    if outcome.status is not Status.CANCELLED:
        _emit_phase(instance, Phase.FAIL if outcome.failed else Phase.END, context)
        if armed is not None:
            context.scheduler.after_sends(armed.pop_all().close)


def _emit_phase(instance: Instance | Composed, phase: Phase, context: ExecutionContext) -> None:
    """Emit a predefined event; those of a composition, which has no name, only with a subscriber."""
    if isinstance(instance, Composed) and not instance.has_channel(phase):
        return
    events = context.services.events
    events.emit(events.phase(instance, None, phase), {}, context.task.past)


def run_composed(context: ExecutionContext, carry: Carry) -> Awaitable[Outcome]:
    """Run the body of a composition; `start`, then `end` or `fail` occur if its `with:` block may use them."""
    return (
        carry(context) if context.invoked is None else _run_composed(context, context.invoked.take(context), carry)
    )


async def _run_composed(context: ExecutionContext, composed: Instance | Composed, carry: Carry) -> Outcome:
    _emit_phase(composed, Phase.START, context)
    try:
        outcome = await carry(context.invoking(None))
    except asyncio.CancelledError:
        _emit_end(composed, _outcome_from_around(context), context)
        raise
    _emit_end(composed, outcome, context)
    return outcome


def begin_composition(plan: Serial | Parallel | OneOf, context: ExecutionContext) -> Begun:
    """Prepare a composition: its object `it` for the `with:` block, and instances of its modifiers.

    Raises:
        EvaluationError: A value cannot be computed, or no values meet all constraints.
    """
    if not (plan.constraints or plan.modifications or plan.duration):
        return context, (), ()
    plans = context.services.plan
    first = Composed(context.path, Fields())
    modifying = apply(plan.modifications, plans.modifiers, context.environment({"it": first}), first, OF_BLOCK)
    applied = tuple(with_nested(modifying))

    def fill(composed: Composed, environment: Environment) -> None:
        times, seed, run = times_of(plan, environment), environment.seed, environment.run
        invocation = Invocation({}, None, plan.constraints, environment, seed, run, applied, times)
        choose_parameters(plans, (), composed, invocation)

    def make(again: ExecutionContext) -> Composed:
        composed = Composed(again.path, Fields() if has_times else first.fields)
        for modifier in applied:
            modifier.rebind(composed)
        if has_times:
            fill(composed, context.like(again).environment())
        return composed

    fill(first, context.environment())
    has_times = bool(plan.constraints or first.windows)
    return context.invoking(Invoked(first, make, context.task.depth, True)), modifying, ()


def begin_invocation(plan: InvokeScenario | InvokeAction, context: ExecutionContext) -> Begun:
    """Prepare an invocation: an instance, and instances of its modifiers.

    Raises:
        EvaluationError: A value cannot be computed, or no values meet all constraints.
    """
    outside = context if context.invoked is None else context.invoking(None)
    first = _empty(plan, outside)
    modifying, own = _modifiers(plan, first, outside)
    applied = tuple(with_nested((*modifying, *own))) if modifying or own else ()
    _fill(first, plan, outside, applied)

    def make(again: ExecutionContext) -> Instance:
        there = outside.like(again)
        instance = _empty(plan, there)
        for modifier in applied:
            modifier.rebind(instance)
        _fill(instance, plan, there, applied)
        return instance

    is_watched = bool(applied) and any(each.modifier.on or each.modifier.samples for each in applied)
    invoked = Invoked(first, make, context.task.depth, is_watched)
    return context.invoking(invoked), modifying, own


def _modifiers(
    plan: InvokeScenario | InvokeAction, first: Instance, outside: ExecutionContext
) -> tuple[tuple[Modifying, ...], tuple[Modifying, ...]]:
    """Return the modifications of an invocation, and those of the invoked type."""
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


def _empty(plan: InvokeScenario | InvokeAction, context: ExecutionContext) -> Instance:
    """Create an instance without values."""
    plans = context.services.plan
    declared = plans.invoked(plan)
    actor = evaluate(plan.actor, context.environment()) if plan.actor is not None else None
    assert actor is None or isinstance(actor, Actor)
    return Instance(context.path, Fields(), declared, {"actor": actor} if actor is not None else {})


def _fill(
    instance: Instance,
    plan: InvokeScenario | InvokeAction,
    context: ExecutionContext,
    applied: tuple[Applied, ...],
) -> None:
    """Choose the values of an instance, and of modifiers without values."""
    services = context.services
    environment: Environment | None = None  # created on demand: nearly all arguments are constants
    given: dict[str, Value] = {}
    for name, argument in plan.arguments:
        if isinstance(argument, Literal):
            given[name] = argument.value
        else:
            environment = environment or context.environment()
            given[name] = evaluate(argument, environment)
    structure, of_globals = instance.declaration.structure, services.plan.globals.fields
    shared = {name: context.instance.fields[name] for name in of_globals} if of_globals else {}
    if not (applied or plan.constraints or plan.duration) and is_given(structure, given):
        take_given(instance.fields, given, shared)  # the usual case
    else:
        environment = environment or context.environment()
        seed, run = environment.seed, environment.run
        times = times_of(plan, environment) if DURATION not in structure.fields else None
        invocation = Invocation(given, instance.actor, plan.constraints, environment, seed, run, applied, times)
        instance.fields.update(shared)
        choose_parameters(services.plan, (structure,), instance, invocation)
    for value in instance.fields.values():
        if isinstance(value, Actor) and services.homes.of(value) is None:
            services.homes.assign(value)
    if plan.label is not None:
        services.scheduler.write(context.position, partial(_take_label, plan.label, instance, context))
    record_instance(instance, context.number, services)


def _take_label(label: str, instance: Instance, context: ExecutionContext) -> None:
    """Bind a label to a new instance, for subscribers and for conditions that have read it."""
    context.instance.latest(label).set(instance)
    context.services.conditions.changed(context.instance, label)
