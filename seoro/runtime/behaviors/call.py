"""`call` (7.2.2.4.7): a method is carried out, in no time, and its result is dropped."""

from __future__ import annotations

from seoro.lang.plan import CallMethod
from seoro.runtime.environment import Environment
from seoro.runtime.evaluate import evaluate
from seoro.runtime.methods import invoke
from seoro.runtime.verdict import SUCCEEDED, Outcome


def run_call(plan: CallMethod, environment: Environment) -> Outcome:
    """Carry it out.

    Raises:
        EvaluationError: The method is undefined, or failed.
    """
    invoke(plan.call, environment, evaluate)
    return SUCCEEDED
