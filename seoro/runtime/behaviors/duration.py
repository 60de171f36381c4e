"""`duration` of compositions and invocations (7.3.13, 7.6.2.4): how long they last, bounds included.

What ends by itself before the lower bound holds until then, unless it has failed. What still runs at the upper
bound is ended: it has succeeded if everything that still runs is open-ended, and failed otherwise.
"""

from __future__ import annotations

from functools import partial

from seoro.lang.plan import Expression
from seoro.runtime.agenda import Scope, Waiter
from seoro.runtime.behaviors.limits import is_all_open_ended, within_limit
from seoro.runtime.behaviors.members import Carry
from seoro.runtime.evaluate import EvaluationError, evaluate
from seoro.runtime.invocation import Place
from seoro.runtime.values import Range
from seoro.runtime.verdict import SUCCEEDED, Outcome, failure


async def run_duration(duration: Expression, place: Place, inner: Carry) -> Outcome:
    """Carry out what lasts that long."""
    agenda = place.agenda
    bounds = evaluate(duration, place.environment())
    assert isinstance(bounds, Range), "checked: a single time is a range, too"
    if bounds.low < 0:
        raise EvaluationError(f"a duration of {bounds.low:g} s: it has to be at least 0 s", duration.span)
    start = agenda.now

    def judge(scope: Scope) -> Outcome:
        if is_all_open_ended(agenda, scope):
            return SUCCEEDED
        return failure(f"still running after {bounds.high:g} s", duration.span)

    outcome, _ = await within_limit(place, bounds.high, partial(inner, place), judge, has_end=True)
    if not outcome.failed and agenda.now < start + bounds.low:
        waiter = Waiter(place.flow)
        agenda.at(start + bounds.low, waiter)
        await agenda.wait(waiter)
    return outcome
