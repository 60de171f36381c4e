"""Execution of any behavior: dispatch by kind, records of its start and end, and its predefined events."""

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
    Scenario,
    Serial,
    Until,
    Wait,
)
from seoro.runtime.behaviors.action import run_action
from seoro.runtime.behaviors.call import run_call
from seoro.runtime.behaviors.duration import run_duration
from seoro.runtime.behaviors.emit import run_emit
from seoro.runtime.behaviors.invoke import begin_composition, begin_invocation, run_composed, run_instance
from seoro.runtime.behaviors.one_of import run_one_of
from seoro.runtime.behaviors.override import end_labelled, is_overridden, run_override, start_labelled
from seoro.runtime.behaviors.parallel import run_parallel
from seoro.runtime.behaviors.records import record_end, record_start
from seoro.runtime.behaviors.serial import run_serial
from seoro.runtime.behaviors.timing import timing_of
from seoro.runtime.behaviors.until import run_until
from seoro.runtime.behaviors.wait import run_wait
from seoro.runtime.execution.context import BehaviorScope, Carry, ExecutionContext
from seoro.runtime.execution.names import type_of
from seoro.runtime.instances.applied import Applied, Modifying, modifiers_of, with_nested
from seoro.runtime.instances.instances import Instance, newly_held
from seoro.runtime.instances.times import DURATION
from seoro.runtime.kernel.stack import descend
from seoro.runtime.kernel.task import Task
from seoro.runtime.values.environment import EvaluationError
from seoro.runtime.verdict import CANCELLED, SUCCEEDED, Cancelled, Outcome

LEVELS = 8  # of nested behaviors that await each other directly


def perform(behavior: Behavior, context: ExecutionContext) -> Awaitable[Outcome]:
    """Run a behavior from its start, which is a step, to its end.

    Raises:
        asyncio.CancelledError: A surrounding scope was cancelled.
    """
    running = recorded(behavior, context, partial(_carry_modified, behavior))
    return running if len(context.position) % LEVELS else descend(running)


def perform_member(
    task: Task, behavior: Behavior, index: int, context: ExecutionContext
) -> Coroutine[Any, Any, Outcome]:
    """Run a member of a composition in a task of its own.

    Args:
        task: The task.
        behavior: The member.
        index: Its index in the composition.
        context: Context of the composition.
    """
    return recorded(behavior, context.member(index, behavior, task), partial(_carry_modified, behavior))


async def recorded(behavior: Behavior, context: ExecutionContext, carry: Carry) -> Outcome:
    """Run a behavior by `carry`, with its records and events."""
    services, label = context.services, behavior.label
    await context.task.step()
    if label is not None and (overridden := is_overridden(label, context)) is not None:
        message = f"`{label}` does not start: {overridden.reason}"
        services.trace.log(message, "debug", behavior.span)
        return overridden
    number = context.number = record_start(behavior, context, context.task.past)
    outcome = CANCELLED
    if label is not None:
        _emit_phase(label, Phase.START, context)
    with BehaviorScope(behavior, context) as scope:
        if label is not None:
            start_labelled(label, context, scope)
        try:
            try:
                if services.debugger is not None:
                    await services.debugger.before(scope)
                services.count_start(behavior.span, len(context.position))
                outcome = await carry(context)
            except EvaluationError as error:
                await _end_run(error, context)
            finally:
                if label is not None:
                    end_labelled(label, context, scope)
        except asyncio.CancelledError:
            if not scope.is_cancelled_itself:
                _record_cancelled(number, behavior, context)
            raise
    outcome = scope.outcome or outcome
    record_end(number, outcome, services, context.task.past)
    if label is not None:
        _emit_phase(label, Phase.FAIL if outcome.failed else Phase.END, context)
    if services.debugger is not None:
        await services.debugger.after(scope)
    return outcome


def _emit_phase(label: str, phase: Phase, context: ExecutionContext) -> None:
    """Emit a predefined event of a label."""
    events = context.services.events
    events.emit(events.phase(context.instance, label, phase), {}, context.task.past)


async def _end_run(error: EvaluationError, context: ExecutionContext) -> None:
    """End the run as an error because an expression has no value."""
    context.services.fail(error)
    await context.task.step()
    raise AssertionError("the end of the run has cancelled this task")


def _record_cancelled(number: int, behavior: Behavior, context: ExecutionContext) -> None:
    """Record the end of a behavior that was cancelled with a surrounding scope."""
    services, task = context.services, context.task
    record_end(number, CANCELLED, services, task.past)
    if services.is_ending:
        took = time.monotonic() - task.cancelled_at
        services.cancelled.append(Cancelled(context.path, type_of(behavior), behavior.span, took, task.overran))


def _carry_modified(behavior: Behavior, context: ExecutionContext) -> Awaitable[Outcome]:
    """Run a behavior within its modifications."""
    match behavior:  # the most frequent kinds first: each further case takes time
        case InvokeAction() | InvokeScenario():
            inside, modifying, own = begin_invocation(behavior, context)
        case Wait():
            return run_wait(behavior, context)
        case Emit():
            return _at_once(run_emit(behavior, context, context.environment(), context.task.past))
        case CallMethod():
            return _at_once(run_call(behavior, context.environment()))
        case Serial() | Parallel() | OneOf():
            inside, modifying, own = begin_composition(behavior, context)
        case _:
            assert_never(behavior)
    carry = lasting(inside, within(own, partial(_carry_out, behavior)))
    return within(modifying, carry)(inside)


async def _at_once(outcome: Outcome) -> Outcome:
    return outcome


def lasting(context: ExecutionContext, carry: Carry) -> Carry:
    """Nest a behavior in its `duration`, if it has one."""
    has_duration = context.invoked is not None and DURATION in context.invoked.instance.windows
    return partial(run_duration, inner=carry) if has_duration else carry


def within(modifying: Iterable[Modifying], carry: Carry) -> Carry:
    """Nest a behavior in its modifications; the last one in the text is the closest."""
    modifying = tuple(modifying)
    if not modifying:
        return carry
    for is_until, group in groupby(reversed(modifying), lambda each: isinstance(each, Until)):
        if is_until:  # adjacent directives form one
            directives = [each for each in group if isinstance(each, Until)]
            carry = partial(run_until, directives[::-1], inner=carry)
            continue
        for each in group:
            carry = partial(_modify, each, inner=carry)
    return carry


def carry_scenario(context: ExecutionContext) -> Awaitable[Outcome]:
    """Run the scenario that is invoked in a context."""
    instance = context.take_invoked()
    body = partial(_perform_body, instance)
    return _held_within(instance, lambda inside: run_instance(instance, inside, body), context)


def _perform_body(instance: Instance, context: ExecutionContext) -> Awaitable[Outcome]:
    """Run the `do` of a scenario (7.3.5.1.3)."""
    assert isinstance(instance.declaration, Scenario)
    body = instance.declaration.body
    return perform(body, context.member(0, body)) if body is not None else _at_once(SUCCEEDED)


def _held_within(instance: Instance, carry: Carry, context: ExecutionContext) -> Awaitable[Outcome]:
    """Run an instance within the modifiers of the structs and actors that it is the first to hold."""
    if not context.services.has_modified_objects:
        return carry(context)
    modifying: list[Applied] = []
    for held, path in newly_held(instance, context.services.modified):
        modifiers = modifiers_of(held)
        for applied in with_nested(modifiers):
            applied.rebind(instance)
            applied.holder = path
        modifying += modifiers
    return within(modifying, carry)(context)


def _modify(modifying: Modifying, context: ExecutionContext, inner: Carry) -> Awaitable[Outcome]:
    """Run a modified behavior on the stack of `carried`: modifications may be nested deeply."""
    return descend(_carry_within(modifying, context, inner))


async def _carry_within(modifying: Modifying, context: ExecutionContext, inner: Carry) -> Outcome:
    match modifying:
        case Applied():
            from seoro.runtime.behaviors.modifier import run_modifier  # noqa: PLC0415 - few have modifiers

            return await run_modifier(modifying, context, inner, within)
        case Override():
            return await run_override(modifying, context, inner)
        case Until():
            raise AssertionError("combined with adjacent directives")
        case _:
            assert_never(modifying)


def _carry_out(
    behavior: Serial | Parallel | OneOf | InvokeAction | InvokeScenario, context: ExecutionContext
) -> Awaitable[Outcome]:
    match behavior:
        case InvokeAction():
            instance = context.take_invoked()
            return _held_within(instance, partial(run_action, behavior, instance), context)
        case Serial():
            return run_composed(context, lambda inside: run_serial(behavior, inside, perform))
        case Parallel():
            timing = timing_of(behavior, context)
            return run_composed(context, lambda inside: run_parallel(behavior, timing, inside, perform_member))
        case OneOf():
            return run_composed(context, lambda inside: run_one_of(behavior, inside, perform_member))
        case InvokeScenario():
            return carry_scenario(context)
        case _:
            assert_never(behavior)
