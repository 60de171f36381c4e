"""Invocation of an action, implemented in Python.

Its arguments are evaluated when the invocation starts. It succeeds when its function returns, and fails when that
raises `ActionFailed` or its backend refuses a request. Other exceptions are faults of the test, and end the run as
an error, as does a lost backend. Its events `start`, then `end` or `fail` occur for items that sample it. Its task
is open-ended until it returns, if its function is.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable

from seoro.errors import ActionFailed, BackendLost, BackendRefused, BackendStopped
from seoro.lang.plan import InvokeAction
from seoro.lang.source import Span
from seoro.runtime.actions.driver import ActionDriver
from seoro.runtime.behaviors.invoke import run_instance
from seoro.runtime.execution.context import ExecutionContext
from seoro.runtime.execution.names import invoked_name, name_of
from seoro.runtime.execution.resources import Use
from seoro.runtime.instances.instances import Instance
from seoro.runtime.values.environment import EvaluationError
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
            await ActionDriver(bound, instance, plan, context)
        else:
            use = Use(instance.actor, part)
            async with services.common.uses.alone(use, context.task, name_of(plan), plan.span):
                await ActionDriver(bound, instance, plan, context)
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
