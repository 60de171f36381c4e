"""What becomes of an exception in Python that carries out an action or a modifier."""

from __future__ import annotations

from seoro.errors import ActionFailed, BackendLost, BackendRefused, BackendStopped
from seoro.lang.source import Span
from seoro.runtime.evaluate import EvaluationError
from seoro.runtime.explain import explain_action
from seoro.runtime.instances import Instance
from seoro.runtime.place import Place
from seoro.runtime.verdict import SUCCEEDED, Outcome, RunStatus, failure


def judge(error: Exception, name: str, span: Span, place: Place) -> Outcome:
    """The outcome of a function that raised; faults and lost backends end the run as an error, stops cancel it.

    Args:
        error: What it raised.
        name: What it carries out.
        span: Where that stands.
        place: Where it is carried out.
    """
    services = place.services
    match _cause(error):
        case BackendStopped() as stopped:
            services.decide(RunStatus.CANCELLED, str(stopped), span)
        case ActionFailed() | BackendRefused() as refusal:
            invoked = place.invoked.instance if place.invoked is not None else None
            instance = invoked if isinstance(invoked, Instance) else place.instance
            return failure(f"`{name}` failed: {refusal}", span, explain_action(place, instance))
        case BackendLost() as lost:
            services.decide(RunStatus.ERROR, str(lost), span)
        case EvaluationError() as valueless:
            services.decide(RunStatus.ERROR, str(valueless), valueless.span)
        case fault:
            services.fault = fault
            services.decide(RunStatus.ERROR, f"`{name}` raised {type(fault).__name__}: {fault}", span)
    return SUCCEEDED  # of no account: the run is ended


def _cause(error: Exception) -> Exception:
    """What went wrong; of what several tasks of an action raised, a fault or a lost backend before a failure."""
    if not isinstance(error, ExceptionGroup):
        return error
    causes = [_cause(part) for part in error.exceptions]
    return next((cause for cause in causes if not _is_failure(cause)), causes[0])


def _is_failure(error: Exception) -> bool:
    return isinstance(error, ActionFailed | BackendRefused) and not isinstance(error, BackendStopped)
