"""`duration` of compositions and invocations (7.3.13, 7.6.2.4): how long they last, bounds included.

An argument bounds it, and so do constraints on `it.duration`; where these leave a choice, all of it is left to
the run. What ends by itself before the lower bound holds until then, unless it has failed. What still runs at the
upper bound is ended: it has succeeded if everything that still runs is open-ended, and failed otherwise.
"""

from __future__ import annotations

import time
from functools import partial
from math import inf

from seoro.lang.plan import InvokeAction, InvokeScenario, OneOf, Parallel, Serial
from seoro.lang.source import Span
from seoro.runtime.agenda import Scope, Waiter
from seoro.runtime.behaviors.limits import is_all_open_ended, within_limit
from seoro.runtime.behaviors.members import Carry
from seoro.runtime.choose.times import DURATION, END_TO_END, START_TO_START, Times, Window
from seoro.runtime.environment import Environment
from seoro.runtime.evaluate import EvaluationError, evaluate
from seoro.runtime.place import Place
from seoro.runtime.values import Range
from seoro.runtime.verdict import SUCCEEDED, Outcome, RunStatus, failure


def times_of(plan: Serial | Parallel | OneOf | InvokeScenario | InvokeAction, environment: Environment) -> Times:
    """What the arguments of a behavior say about its times.

    Raises:
        EvaluationError: One has no value, or a duration is negative.
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
            assert isinstance(bounds, Range), "checked: a single time is a range, too"
            if name == DURATION:
                _check(bounds, argument.span)
            given[name] = bounds, argument.span
    if isinstance(plan, Parallel):
        return Times(plan.span, given, plan.overlap, plan.is_overlap_given)
    return Times(plan.span, given)


def _check(duration: Range, span: Span) -> None:
    if duration.low < 0:
        raise EvaluationError(f"a duration of {duration.low:g} s: it has to be at least 0 s", span)


async def run_duration(place: Place, inner: Carry) -> Outcome:
    """Carry out what has a window for its duration."""
    assert place.invoked is not None, "it has a window"
    agenda, window = place.agenda, place.invoked.instance.windows[DURATION]
    bounds = window.bounds
    _check(bounds, window.span)
    start, began = agenda.now, time.monotonic()

    def judge(scope: Scope) -> Outcome:
        if is_all_open_ended(agenda, scope):
            return SUCCEEDED
        if loss := place.services.homes.loss_since(began):
            place.services.decide(RunStatus.ERROR, loss, window.span)
        return failure(_late(window), window.span)

    if bounds.high == inf:
        outcome = await inner(place)
    else:
        outcome, _ = await within_limit(place, bounds.high, partial(inner, place), judge, has_end=True)
    if not outcome.failed and agenda.now < start + bounds.low:
        waiter = Waiter(place.flow)
        agenda.at(start + bounds.low, waiter)
        await agenda.wait(waiter)
    return outcome


def _late(window: Window) -> str:
    """What to say of what still runs at the upper bound."""
    reason = f"still running after {window.bounds.high:g} s"
    return f"{reason}, against `{window.text}`" if window.text else reason
