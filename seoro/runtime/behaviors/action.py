"""Invocation of an action: Python carries it out.

Its arguments are evaluated when the invocation starts. It succeeds when its function returns and fails when that
raises `ActionFailed` or its backend refuses a request. Any other exception is a fault of the test and ends the run
as an error, as does a backend that is lost. Its `start`, then its `end` or `fail` occur for items that sample it.
Until it returns, its flow is as open-ended as its function says.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable
from functools import partial

from seoro.lang.plan import InvokeAction
from seoro.runtime.actions import BoundAction
from seoro.runtime.behaviors.faults import judge
from seoro.runtime.behaviors.invoke import run_instance
from seoro.runtime.blocking import Meter, place_of_thread
from seoro.runtime.context import ActionContext
from seoro.runtime.drive import Drive
from seoro.runtime.instances import Instance
from seoro.runtime.place import Place, invoked_name, name_of
from seoro.runtime.uses import Use
from seoro.runtime.verdict import SUCCEEDED, Outcome, RunStatus


def run_action(plan: InvokeAction, instance: Instance, place: Place) -> Awaitable[Outcome]:
    """Carry it out."""
    if not (instance.reacts or place.services.coverage.concerns(instance)):
        return _carry_out(plan, instance, place)
    return run_instance(instance, place, lambda inside: _carry_out(plan, instance, inside))


async def _carry_out(plan: InvokeAction, instance: Instance, place: Place) -> Outcome:
    """Carry out an instance of an action."""
    services = place.services
    bound = services.actions[plan.action]
    outcome = SUCCEEDED
    place.flow.open_ended = bound.mark.open_ended
    try:
        part = bound.part_of(instance.fields)
        if part is None:
            await _drive(bound, instance, plan, place)
        else:
            use = Use(instance.actor, part)
            async with services.common.uses.alone(use, place.flow, name_of(plan), plan.span):
                await _drive(bound, instance, plan, place)
    except Exception as error:
        outcome = judge(error, invoked_name(plan), plan.span, place)
    except SystemExit as error:
        services.decide(RunStatus.ERROR, f"`{invoked_name(plan)}` raised SystemExit: {error}", plan.span)
    except asyncio.CancelledError:
        if place.flow.ended is None:
            reason = f"`{invoked_name(plan)}` raised CancelledError, and nothing has cancelled it"
            services.decide(RunStatus.ERROR, reason, plan.span)
    finally:
        place.flow.open_ended = False
    if place.flow.ended is not None:  # it was cancelled, whatever became of its clean-up
        if outcome.failed:
            services.trace.log(outcome.reason, "warning", plan.span)
        raise asyncio.CancelledError
    if services.decision is not None:
        await place.agenda.step(place.flow)  # to be cancelled by the end of the run
    return outcome


def _drive(bound: BoundAction, instance: Instance, plan: InvokeAction, place: Place) -> Drive:
    """Drive the function of an action to its end, and tell of what it does that harms others."""
    watch = _Watch(bound, plan, place)
    context = watch.context
    coroutine = bound.call(context, instance.actor, instance.fields)
    watch.meter.attach(coroutine)
    return Drive(coroutine, place.flow, place.agenda, watch.meter, watch)


class _Watch:
    """Tells of what an action does that harms others.

    Args:
        bound: The action.
        plan: Its invocation.
        place: Where it is carried out.
    """

    __slots__ = ("_bound", "_place", "_plan", "context", "meter")

    def __init__(self, bound: BoundAction, plan: InvokeAction, place: Place) -> None:
        self._bound = bound
        self._plan = plan
        self._place = place
        common = place.services.common
        # Nothing here refers back to this, so that it is freed without the help of the garbage collector.
        self.meter = Meter(common.share, partial(common.warn_of_blocking, plan.action, plan.span))
        self.context = ActionContext(place, plan, self.meter)

    @property
    def grace(self) -> float:
        """The time for its clean-up [s]."""
        return self.context.grace

    def cancelled(self) -> None:
        """It is told that it is cancelled."""
        self._place.services.trace.record("behavior.cancel", id=self._place.parent)

    def overrun(self) -> None:
        """Its clean-up has taken longer than that."""
        name, context, place = self._plan.action, self.context, self._place
        text = f"the clean-up of `{name}` took longer than {context.grace:g} s"
        where = self.meter.place
        if context.thread is not None:
            text = f"the thread of `{name}` has not ended {context.grace:g} s after it was cancelled"
            where = place_of_thread(context.thread, self._bound.function)
        place.flow.overran = True
        text = f"{text}; it is at {where}" if where else text
        place.services.decide(RunStatus.ERROR, text, self._plan.span)
