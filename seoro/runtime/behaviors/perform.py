"""Carrying out any behavior: its start and end in the trace, its predefined events, and the choice of its kind."""

from __future__ import annotations

import asyncio
from collections.abc import Generator, Iterable
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from itertools import groupby
from typing import assert_never

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
from seoro.runtime.applied import Applied, Modifying
from seoro.runtime.behaviors.action import run_action
from seoro.runtime.behaviors.call import run_call
from seoro.runtime.behaviors.duration import run_duration
from seoro.runtime.behaviors.emit import run_emit
from seoro.runtime.behaviors.invoke import begin_composition, begin_invocation
from seoro.runtime.behaviors.members import Carry
from seoro.runtime.behaviors.modifier import run_modifier
from seoro.runtime.behaviors.one_of import run_one_of
from seoro.runtime.behaviors.override import end_labelled, is_overridden, run_override, start_labelled
from seoro.runtime.behaviors.parallel import run_parallel
from seoro.runtime.behaviors.records import record_end, record_start
from seoro.runtime.behaviors.scenario import run_scenario
from seoro.runtime.behaviors.serial import run_serial
from seoro.runtime.behaviors.until import run_until
from seoro.runtime.behaviors.wait import run_wait
from seoro.runtime.evaluate import EvaluationError
from seoro.runtime.invocation import Place
from seoro.runtime.verdict import Outcome, RunStatus, Status


async def perform(behavior: Behavior, place: Place) -> Outcome:
    """Carry out a behavior, from its start, which is a step, to its end.

    Raises:
        asyncio.CancelledError: Something around it was ended.
    """
    return await recorded(behavior, place, partial(_carry_modified, behavior))


async def recorded(behavior: Behavior, place: Place, carry: Carry) -> Outcome:
    """Carry out a behavior in a given way, with its records and events."""
    services = place.services
    await services.agenda.step(place.flow)
    if behavior.label is not None and (overridden := is_overridden(behavior.label, place)) is not None:
        message = f"`{behavior.label}` does not start: {overridden.reason}"
        services.trace.record("log", level="debug", message=message, source=str(behavior.span))
        return overridden
    number = record_start(behavior, place)
    if behavior.label is not None:
        services.events.emit(place.instance.phase(behavior.label, Phase.START), {}, place.flow.past)
    with _scope_of(behavior, place) as scope:
        try:
            outcome = await _evaluating(behavior, replace(place, parent=number), carry)
        except asyncio.CancelledError:
            if not services.agenda.left(scope):
                record_end(number, Outcome(Status.CANCELLED), place)
                services.cancelled.append(place.path)
                raise
            assert scope.outcome is not None, "it was ended"
            outcome = scope.outcome
    record_end(number, outcome, place)
    if behavior.label is not None:
        phase = Phase.FAIL if outcome.failed else Phase.END
        services.events.emit(place.instance.phase(behavior.label, phase), {}, place.flow.past)
    return outcome


@contextmanager
def _scope_of(behavior: Behavior, place: Place) -> Generator[Scope]:
    """The scope of a behavior, by which it is ended; under its label, others find it."""
    with place.agenda.scope(place.flow) as scope:
        if behavior.label is None:
            yield scope
            return
        start_labelled(behavior.label, place, scope)
        try:
            yield scope
        finally:
            end_labelled(behavior.label, place, scope)


async def _evaluating(behavior: Behavior, place: Place, carry: Carry) -> Outcome:
    """Carry out; an expression without a value ends the run as an error."""
    try:
        place.services.count_start(behavior.span, len(place.position))
        return await carry(place)
    except EvaluationError as error:
        place.services.decide(RunStatus.ERROR, str(error), error.span)
    await place.agenda.step(place.flow)
    raise AssertionError("the run has ended, and this flow with it")


async def _carry_modified(behavior: Behavior, place: Place) -> Outcome:
    """Carry out a behavior within what modifies it."""
    carry: Carry = partial(_carry_out, behavior)
    match behavior:
        case Wait() | Emit() | CallMethod():
            return await carry(place)
        case InvokeAction() | InvokeScenario():
            begun = begin_invocation(behavior, place)
        case Serial() | Parallel() | OneOf():
            begun = begin_composition(behavior, place)
        case _:
            assert_never(behavior)
    carry = within(begun.own, carry)
    if behavior.duration is not None:
        carry = partial(run_duration, behavior.duration, inner=carry)
    return await within(begun.modifying, carry)(begun.place)


def within(modifying: Iterable[Modifying], carry: Carry) -> Carry:
    """How something is carried out within what modifies it: what is written last is closest to it."""
    for is_until, group in groupby(reversed(tuple(modifying)), lambda each: isinstance(each, Until)):
        if is_until:  # those that stand in a row are one
            directives = [each for each in group if isinstance(each, Until)]
            carry = partial(run_until, directives[::-1], inner=carry)
            continue
        for each in group:
            carry = partial(_modify, each, inner=carry)
    return carry


async def _modify(modifying: Modifying, place: Place, inner: Carry) -> Outcome:
    """Carry out what is modified, by what modifies it."""
    match modifying:
        case Applied():
            return await run_modifier(modifying, place, inner, within)
        case Override():
            return await run_override(modifying, place, inner)
        case Until():
            raise AssertionError("carried out with those in its row")
        case _:
            assert_never(modifying)


async def _carry_out(behavior: Behavior, place: Place) -> Outcome:
    match behavior:
        case Serial():
            return await run_serial(behavior, place, perform)
        case Parallel():
            return await run_parallel(behavior, place, perform)
        case OneOf():
            return await run_one_of(behavior, place, perform)
        case Wait():
            return await run_wait(behavior, place)
        case Emit():
            return run_emit(behavior, place, place.environment(), place.flow.past)
        case CallMethod():
            return run_call(behavior, place.environment())
        case InvokeAction():
            return await run_action(behavior, place)
        case InvokeScenario():
            return await run_scenario(place.take_invoked(), place, perform)
        case _:
            assert_never(behavior)
