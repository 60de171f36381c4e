"""Carrying out any behavior: its start and end in the trace, its predefined events, and the choice of its kind."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Coroutine, Iterable
from functools import partial
from itertools import groupby
from typing import Any, assert_never

from seoro.lang.plan import (
    Behavior,
    CallMethod,
    Emit,
    InvokeAction,
    InvokeScenario,
    OneOf,
    Override,
    Parallel,
    Phase,
    Serial,
    Until,
    Wait,
)
from seoro.runtime.agenda import Scope
from seoro.runtime.applied import Applied, Modifying, with_nested
from seoro.runtime.behaviors.action import run_action
from seoro.runtime.behaviors.call import run_call
from seoro.runtime.behaviors.duration import run_duration
from seoro.runtime.behaviors.emit import run_emit
from seoro.runtime.behaviors.invoke import begin_composition, begin_invocation, run_composed
from seoro.runtime.behaviors.members import Carry
from seoro.runtime.behaviors.modifier import run_modifier
from seoro.runtime.behaviors.one_of import run_one_of
from seoro.runtime.behaviors.overlap import timing_of
from seoro.runtime.behaviors.override import end_labelled, is_overridden, run_override, start_labelled
from seoro.runtime.behaviors.parallel import run_parallel
from seoro.runtime.behaviors.records import record_end, record_start
from seoro.runtime.behaviors.scenario import run_scenario
from seoro.runtime.behaviors.serial import run_serial
from seoro.runtime.behaviors.until import run_until
from seoro.runtime.behaviors.wait import run_wait
from seoro.runtime.choose.times import DURATION
from seoro.runtime.evaluate import EvaluationError
from seoro.runtime.holding import newly_held
from seoro.runtime.instances import Instance
from seoro.runtime.place import Place, type_of
from seoro.runtime.stack import descend
from seoro.runtime.verdict import CANCELLED, Cancelled, Outcome, RunStatus

LEVELS = 8  # of behaviors that await each other directly


def perform(behavior: Behavior, place: Place) -> Awaitable[Outcome]:
    """Carry out a behavior, from its start, which is a step, to its end.

    Raises:
        asyncio.CancelledError: Something around it was ended.
    """
    carrying = recorded(behavior, place, partial(_carry_modified, behavior))
    return carrying if len(place.position) % LEVELS else descend(carrying)


async def recorded(behavior: Behavior, place: Place, carry: Carry) -> Outcome:
    """Carry out a behavior in a given way, with its records and events."""
    services = place.services
    agenda = services.agenda
    await agenda.step(place.flow)
    if behavior.label is not None and (overridden := is_overridden(behavior.label, place)) is not None:
        message = f"`{behavior.label}` does not start: {overridden.reason}"
        services.trace.log(message, "debug", behavior.span)
        return overridden
    number = record_start(behavior, place)
    if behavior.label is not None:
        services.events.emit(place.instance.phase(behavior.label, Phase.START), {}, place.flow.past)
    with agenda.scope(place.flow) as scope:
        try:
            carrying = _evaluating(behavior, place.inside(number), carry)
            if behavior.label is not None:
                carrying = _labelled(behavior.label, place, scope, carrying)
            outcome = await carrying
        except asyncio.CancelledError:
            if not agenda.left(scope):
                record_end(number, CANCELLED, place)
                if services.is_ending:
                    flow = place.flow
                    took = time.monotonic() - flow.delivered_at
                    services.cancelled.append(
                        Cancelled(place.path, type_of(behavior), behavior.span, took, flow.overran)
                    )
                raise
            assert scope.outcome is not None, "it was ended"
            outcome = scope.outcome
    record_end(number, outcome, place)
    if behavior.label is not None:
        phase = Phase.FAIL if outcome.failed else Phase.END
        services.events.emit(place.instance.phase(behavior.label, phase), {}, place.flow.past)
    return outcome


async def _labelled(label: str, place: Place, scope: Scope, carrying: Coroutine[Any, Any, Outcome]) -> Outcome:
    """Carry out a behavior that others find under its label meanwhile."""
    start_labelled(label, place, scope)
    try:
        return await carrying
    finally:
        end_labelled(label, place, scope)


async def _evaluating(behavior: Behavior, place: Place, carry: Carry) -> Outcome:
    """Carry out; an expression without a value ends the run as an error."""
    try:
        place.services.count_start(behavior.span, len(place.position))
        return await carry(place)
    except EvaluationError as error:
        place.services.decide(RunStatus.ERROR, str(error), error.span)
    await place.agenda.step(place.flow)
    raise AssertionError("the run has ended, and this flow with it")


def _carry_modified(behavior: Behavior, place: Place) -> Awaitable[Outcome]:
    """Carry out a behavior within what modifies it."""
    match behavior:  # that it is something else takes longer to find than that it is this
        case InvokeAction() | InvokeScenario():
            begun = begin_invocation(behavior, place)
        case Wait():
            return run_wait(behavior, place)
        case Emit():
            return _at_once(run_emit(behavior, place, place.environment(), place.flow.past))
        case CallMethod():
            return _at_once(run_call(behavior, place.environment()))
        case Serial() | Parallel() | OneOf():
            begun = begin_composition(behavior, place)
        case _:
            assert_never(behavior)
    carry = lasting(begun.place, within(begun.own, partial(_carry_out, behavior)))
    return within(begun.modifying, carry)(begun.place)


async def _at_once(outcome: Outcome) -> Outcome:
    return outcome


def lasting(place: Place, carry: Carry) -> Carry:
    """How something is carried out that has a `duration`, if anything is said about that."""
    has_duration = place.invoked is not None and DURATION in place.invoked.instance.windows
    return partial(run_duration, inner=carry) if has_duration else carry


def within(modifying: Iterable[Modifying], carry: Carry) -> Carry:
    """How something is carried out within what modifies it: what is written last is closest to it."""
    modifying = tuple(modifying)
    if not modifying:
        return carry
    for is_until, group in groupby(reversed(modifying), lambda each: isinstance(each, Until)):
        if is_until:  # those that stand in a row are one
            directives = [each for each in group if isinstance(each, Until)]
            carry = partial(run_until, directives[::-1], inner=carry)
            continue
        for each in group:
            carry = partial(_modify, each, inner=carry)
    return carry


def carry_scenario(place: Place) -> Awaitable[Outcome]:
    """Carry out the scenario that is invoked at a place."""
    instance = place.take_invoked()
    return _held_within(instance, lambda inside: run_scenario(instance, inside, perform), place)


def _held_within(instance: Instance, carry: Carry, place: Place) -> Awaitable[Outcome]:
    """Carry out an instance within the modifiers of the structs and actors that it is the first to hold."""
    if not place.services.has_modified_objects:
        return carry(place)
    modifying: list[Applied] = []
    for held, path in newly_held(instance, place.services.modified):
        for applied in with_nested(held.modifiers):
            applied.turn_to(instance)
            applied.holder = path
        modifying += held.modifiers
    return within(modifying, carry)(place)


def _modify(modifying: Modifying, place: Place, inner: Carry) -> Awaitable[Outcome]:
    """Carry out what is modified, by what modifies it; of that, there may be any number."""
    return descend(_carry_within(modifying, place, inner))


async def _carry_within(modifying: Modifying, place: Place, inner: Carry) -> Outcome:
    match modifying:
        case Applied():
            return await run_modifier(modifying, place, inner, within)
        case Override():
            return await run_override(modifying, place, inner)
        case Until():
            raise AssertionError("carried out with those in its row")
        case _:
            assert_never(modifying)


def _carry_out(
    behavior: Serial | Parallel | OneOf | InvokeAction | InvokeScenario, place: Place
) -> Awaitable[Outcome]:
    match behavior:
        case InvokeAction():
            instance = place.take_invoked()
            return _held_within(instance, partial(run_action, behavior, instance), place)
        case Serial():
            return run_composed(place, lambda inside: run_serial(behavior, inside, perform))
        case Parallel():
            timing = timing_of(behavior, place)
            return run_composed(place, lambda inside: run_parallel(behavior, timing, inside, perform))
        case OneOf():
            return run_composed(place, lambda inside: run_one_of(behavior, inside, perform))
        case InvokeScenario():
            return carry_scenario(place)
        case _:
            assert_never(behavior)
