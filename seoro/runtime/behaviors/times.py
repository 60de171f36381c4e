"""Timing arguments of behaviors: `duration`, `start_to_start`, `end_to_end`, `overlap`."""

from __future__ import annotations

from seoro.lang.plan import InvokeAction, InvokeScenario, OneOf, Parallel, Serial
from seoro.lang.source import Span
from seoro.runtime.expressions.evaluation import evaluate
from seoro.runtime.instances.times import DURATION, END_TO_END, START_TO_START, Times
from seoro.runtime.values.environment import Environment, EvaluationError
from seoro.runtime.values.values import Range


def times_of(plan: Serial | Parallel | OneOf | InvokeScenario | InvokeAction, environment: Environment) -> Times:
    """Evaluate the timing arguments of a behavior.

    Raises:
        EvaluationError: An argument has no value, or a duration is negative.
    """
    if plan.duration is None and not isinstance(plan, Parallel):
        return Times(plan.span, {})
    arguments = {DURATION: plan.duration}
    if isinstance(plan, Parallel):
        arguments |= {START_TO_START: plan.start_to_start, END_TO_END: plan.end_to_end}
    given: dict[str, tuple[Range, Span]] = {}
    for name, argument in arguments.items():
        if argument is not None:
            bounds = evaluate(argument, environment)
            assert isinstance(bounds, Range), "checked: a single time becomes a range"
            if name == DURATION:
                check_duration(bounds, argument.span)
            given[name] = bounds, argument.span
    if isinstance(plan, Parallel):
        return Times(plan.span, given, plan.overlap, plan.is_overlap_given)
    return Times(plan.span, given)


def check_duration(duration: Range, span: Span) -> None:
    """Check the bounds of a duration [s].

    Raises:
        EvaluationError: A bound is negative.
    """
    if duration.low < 0:
        raise EvaluationError(f"invalid duration: expected at least 0 s, found {duration.low:g} s", span)
