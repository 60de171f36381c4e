"""`call` (7.2.2.4.7): calls a method, in no time, and drops its result."""

from __future__ import annotations

from seoro.lang.plan import CallMethod
from seoro.runtime.expressions.evaluation import evaluate
from seoro.runtime.functions.methods import invoke
from seoro.runtime.values.environment import Environment
from seoro.runtime.verdict import SUCCEEDED, Outcome


def run_call(plan: CallMethod, environment: Environment) -> Outcome:
    """Call the method.

    Raises:
        EvaluationError: The method is undefined or failed.
    """
    invoke(plan.call, environment, evaluate)
    return SUCCEEDED
