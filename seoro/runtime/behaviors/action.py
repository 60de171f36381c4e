"""Invocation of an action: Python carries it out.

Its arguments are evaluated when the invocation starts. It succeeds when its function returns and fails when that
raises `ActionFailed` or its backend refuses a request. Any other exception is a fault of the test and ends the run
as an error, as does a backend that is lost. Its `start`, then its `end` or `fail` occur for items that sample it.
Until it returns, its flow is as open-ended as its function says.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable

from seoro.lang.plan import InvokeAction
from seoro.runtime.behaviors.faults import judge
from seoro.runtime.behaviors.invoke import run_instance
from seoro.runtime.context import ActionContext
from seoro.runtime.drive import Drive
from seoro.runtime.invocation import Instance, Place
from seoro.runtime.verdict import SUCCEEDED, Outcome, RunStatus


def run_action(plan: InvokeAction, place: Place) -> Awaitable[Outcome]:
    """Carry it out."""
    instance = place.take_invoked()
    if not (instance.reacts or place.services.coverage.concerns(instance)):
        return _drive(plan, instance, place)
    return run_instance(instance, place, lambda inside: _drive(plan, instance, inside))


async def _drive(plan: InvokeAction, instance: Instance, place: Place) -> Outcome:
    """Carry out an instance of an action."""
    services = place.services
    arguments = {name: instance.fields[name] for name in instance.declaration.structure.fields}
    coroutine = services.actions[plan.action].call(ActionContext(place, plan), instance.actor, arguments)

    def overrun() -> None:
        reason = f"the clean-up of `{plan.action}` took longer than {services.grace:g} s"
        services.decide(RunStatus.ERROR, reason, plan.span)

    outcome = SUCCEEDED
    place.flow.open_ended = services.actions[plan.action].mark.open_ended
    try:
        await Drive(coroutine, place.flow, place.agenda, services.grace, overrun)
    except Exception as error:
        outcome = judge(error, plan.action, plan.span, place)
    finally:
        place.flow.open_ended = False
    if place.flow.ended is not None:  # it was cancelled, whatever became of its clean-up
        if outcome.failed:
            services.trace.record("log", level="warning", message=outcome.reason, source=str(plan.span))
        raise asyncio.CancelledError
    if services.decision is not None:
        await place.agenda.step(place.flow)  # to be cancelled by the end of the run
    return outcome
