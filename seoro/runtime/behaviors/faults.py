"""Consequences of exceptions in Python code of actions and modifiers."""

from __future__ import annotations

from seoro.errors import ActionFailed, BackendLost, BackendRefused, BackendStopped
from seoro.lang.source import Span
from seoro.runtime.execution.context import ExecutionContext
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
