"""Invocation of an action, implemented in Python.

Its arguments are evaluated when the invocation starts. It succeeds when its function returns, and fails when that
raises `ActionFailed` or its backend refuses a request. Other exceptions are faults of the test, and end the run as
an error, as does a lost backend. Its events `start`, then `end` or `fail` occur for items that sample it. Its task
is open-ended until it returns, if its function is.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Coroutine, Mapping
from functools import partial
from typing import Any, cast

from seoro.errors import ActionFailed, BackendLost, BackendRefused, BackendStopped
from seoro.lang.plan import InvokeAction
from seoro.lang.source import Span
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.actions.driver import ActionDriver
from seoro.runtime.behaviors.invoke import run_instance
from seoro.runtime.execution.blocking import Meter, place_of_thread
from seoro.runtime.execution.context import ExecutionContext
from seoro.runtime.execution.names import invoked_name, name_of
from seoro.runtime.execution.resources import Use
from seoro.runtime.functions.actions import BoundAction
from seoro.runtime.instances.instances import Instance
from seoro.runtime.values.environment import EvaluationError
from seoro.runtime.values.values import Actor, Value
from seoro.runtime.verdict import SUCCEEDED, Outcome, RunStatus, failure


def judge(error: Exception, name: str, span: Span, context: ExecutionContext) -> Outcome:
    """Return the outcome of a function that raised. Faults and lost backends end the run; stops cancel it.

    Args:
        error: The exception.
        name: Name of the action or modifier.
        span: Its invocation.
        context: Context of the invocation.
    """
    services = context.services
    match _cause(error):
        case BackendStopped() as stopped:
            services.decide(RunStatus.CANCELLED, str(stopped), span)
        case ActionFailed() | BackendRefused() as refusal:
            from seoro.runtime.explain.explain import explain_action  # noqa: PLC0415 - for failures

            invoked = context.invoked.instance if context.invoked is not None else None
            instance = invoked if isinstance(invoked, Instance) else context.instance
            return failure(f"`{name}` failed: {refusal}", span, explain_action(context, instance))
        case BackendLost() as lost:
            services.decide(RunStatus.ERROR, str(lost), span)
        case EvaluationError() as valueless:
            services.decide(RunStatus.ERROR, str(valueless), valueless.span)
        case fault:
            services.fault = fault
            services.decide(RunStatus.ERROR, f"`{name}` raised {type(fault).__name__}: {fault}", span)
    return SUCCEEDED  # has no effect: the run is ending


def _cause(error: Exception) -> Exception:
    """Return the decisive exception of a group: a fault or a lost backend takes precedence over a failure."""
    if not isinstance(error, ExceptionGroup):
        return error
    causes = [_cause(part) for part in error.exceptions]
    return next((cause for cause in causes if not _is_failure(cause)), causes[0])


def _is_failure(error: Exception) -> bool:
    return isinstance(error, ActionFailed | BackendRefused) and not isinstance(error, BackendStopped)


def call_action(
    bound: BoundAction, context: ActionContext, actor: Actor | None, fields: Mapping[str, Value]
) -> Coroutine[Any, Any, None]:
    """Call the function of an action. Values refused by the types of the function are a fault of the function.

    Args:
        bound: The action.
        context: Context of the invocation.
        actor: Actor of the invocation, if it has one.
        fields: Values of the parameters; others are ignored.
    """
    converted = {name: convert(fields[name]) for name, convert in bound.converters.items()}
    leading = (actor,) if bound.declaration.has_actor else ()
    if bound.mark.thread:
        from seoro.runtime.actions.threads import run_in_thread  # noqa: PLC0415 - few actions have threads

        return run_in_thread(context, lambda inside: bound.function(inside, *leading, **converted))
    # It is `async`: checked when the scenario was loaded.
    return cast(Coroutine[Any, Any, None], bound.function(context, *leading, **converted))


def run_action(plan: InvokeAction, instance: Instance, context: ExecutionContext) -> Awaitable[Outcome]:
    """Run an action."""
    if not (instance.reacts or context.services.covers(instance)):
        return _carry_out(plan, instance, context)
    return run_instance(instance, context, lambda inside: _carry_out(plan, instance, inside))


async def _carry_out(plan: InvokeAction, instance: Instance, context: ExecutionContext) -> Outcome:
    """Run an instance of an action."""
    services = context.services
    bound = services.actions[plan.action]
    outcome = SUCCEEDED
    if bound.mark.open_ended:
        services.open_ended.add(context.task)
    try:
        part = bound.part_of(instance.fields)
        if part is None:
            await _drive(bound, instance, plan, context)
        else:
            use = Use(instance.actor, part)
            async with services.common.uses.alone(use, context.task, name_of(plan), plan.span):
                await _drive(bound, instance, plan, context)
    except Exception as error:
        outcome = judge(error, invoked_name(plan), plan.span, context)
    except SystemExit as error:
        services.decide(RunStatus.ERROR, f"`{invoked_name(plan)}` raised SystemExit: {error}", plan.span)
    except asyncio.CancelledError:
        if not context.task.is_cancelled:
            reason = f"`{invoked_name(plan)}` raised CancelledError, but was not cancelled"
            services.decide(RunStatus.ERROR, reason, plan.span)
    finally:
        services.open_ended.discard(context.task)
    if context.task.is_cancelled:  # regardless of the result of its clean-up
        if outcome.failed:
            services.trace.log(outcome.reason, "warning", plan.span)
        raise asyncio.CancelledError
    if services.decision is not None:
        await context.task.step()  # to be cancelled by the end of the run
    return outcome


def _drive(bound: BoundAction, instance: Instance, plan: InvokeAction, context: ExecutionContext) -> ActionDriver:
    """Create the driver for the function of an action, which reports blocking and overruns."""
    watch = _Watch(bound, plan, context)
    ctx = watch.ctx
    coroutine = call_action(bound, ctx, instance.actor, instance.fields)
    watch.meter.attach(coroutine)
    return ActionDriver(coroutine, context.task, context.scheduler, watch.meter, watch)


class _Watch:
    """Reports blocking and overruns of an action.

    Args:
        bound: The action.
        plan: Its invocation.
        context: Context of the invocation.
    """

    __slots__ = ("_bound", "_context", "_plan", "ctx", "meter")

    def __init__(self, bound: BoundAction, plan: InvokeAction, context: ExecutionContext) -> None:
        self._bound = bound
        self._plan = plan
        self._context = context
        common = context.services.common
        # No reference back to this object, so that it is freed without the garbage collector.
        self.meter = Meter(common.share, partial(common.warn_of_blocking, plan.action, plan.span))
        self.ctx = ActionContext(context, plan, self.meter)

    @property
    def grace(self) -> float:
        """Time for the clean-up [s]."""
        return self.ctx.grace

    def cancelled(self) -> None:
        """Record the cancellation."""
        self._context.services.trace.record("behavior.cancel", id=self._context.number)

    def overrun(self) -> None:
        """End the run as an error because the clean-up takes too long."""
        name, ctx, context = self._plan.action, self.ctx, self._context
        text = f"the clean-up of `{name}` took longer than {ctx.grace:g} s"
        where = self.meter.place
        if ctx.thread is not None:
            text = f"the thread of `{name}` has not ended {ctx.grace:g} s after it was cancelled"
            where = place_of_thread(ctx.thread, self._bound.function)
        context.task.overran = True
        text = f"{text}; it is at {where}" if where else text
        context.services.decide(RunStatus.ERROR, text, self._plan.span)
