"""`duration` of compositions and invocations (7.3.13, 7.6.2.4): bounds of their length, inclusive.

An argument and constraints on `it.duration` bound it; the rest is free. A behavior that succeeds before the lower
bound holds until then. A behavior that still runs at the upper bound is ended: it succeeds if everything that runs
in it is open-ended, and fails otherwise. So the margin is the time that was left until the upper bound.
"""

from __future__ import annotations

import time
from functools import partial
from math import inf

from seoro.runtime.behaviors.limits import BoundedScope, is_all_open_ended, within_limit
from seoro.runtime.behaviors.timing import check_duration
from seoro.runtime.execution.context import Carry, ExecutionContext
from seoro.runtime.instances.times import DURATION, Window
from seoro.runtime.kernel.cancel_scope import CancelScope
from seoro.runtime.verdict import SUCCEEDED, Outcome, RunStatus, failure


async def run_duration(context: ExecutionContext, inner: Carry) -> Outcome:
    """Run a behavior within the window of its duration."""
    assert context.invoked is not None, "it has a window"
    scheduler, window = context.scheduler, context.invoked.instance.windows[DURATION]
    bounds = window.bounds
    check_duration(bounds, window.span)
    start, began = scheduler.now, time.monotonic()

    def judge(scope: CancelScope) -> Outcome:
        if is_all_open_ended([scope.task, *scope.tasks], scope, context.services.open_ended):
            return SUCCEEDED
        if loss := context.services.homes.loss_since(began):
            context.services.decide(RunStatus.ERROR, loss, window.span)
        return failure(_late(window), window.span)

    if bounds.high == inf:
        outcome = await inner(context)
    else:
        outcome, is_cut_off = await within_limit(
            context, bounds.high, partial(inner, context), judge, BoundedScope
        )
        if not is_cut_off or outcome.failed:  # open-ended behaviors have no length
            distance = 0.0 if is_cut_off else bounds.high - (scheduler.now - start)
            context.services.margins.record(DURATION, distance, bounds.high, window.span)
    if not outcome.failed and scheduler.now < start + bounds.low:
        await context.task.sleep_until(start + bounds.low)
    return outcome


def _late(window: Window) -> str:
    """Return the reason of a failure at the upper bound."""
    reason = f"still running after {window.bounds.high:g} s"
    return f"{reason}; expected `{window.text}`" if window.text else reason
