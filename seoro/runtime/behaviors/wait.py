"""`wait` (7.3.10.4, 7.6.2.5): holds up its flow until the event specification is met.

An event counts from the instant on in which the wait starts, unless it is in the flow's past. `elapsed` counts
from the start of the wait; of a range, the duration is drawn once, from the seed.
"""

from __future__ import annotations

from typing import assert_never

from seoro.lang.plan import DeclaredEvent, Elapsed, Every, Expression, Fall, Holds, OnEvent, PhaseEvent, Rise, Wait
from seoro.runtime.agenda import Waiter
from seoro.runtime.evaluate import EvaluationError, evaluate
from seoro.runtime.events import Occurrence
from seoro.runtime.invocation import Place
from seoro.runtime.values import Range
from seoro.runtime.verdict import SUCCEEDED, Outcome, RunStatus


async def run_wait(plan: Wait, place: Place) -> Outcome:
    """Carry it out."""
    waiter = Waiter(place.flow)
    match plan.event:
        case Elapsed(duration):
            place.agenda.fire_at(place.agenda.now + _draw(duration, place), waiter)
        case OnEvent() as specification:
            _arm(specification, waiter, place)
        case Holds() | Rise() | Fall() | Every():
            raise AssertionError("refused before the run")
        case _:
            assert_never(plan.event)
    place.services.waits[place.flow] = plan.span
    try:
        await place.agenda.wait(waiter)
    finally:
        del place.services.waits[place.flow]
    return SUCCEEDED


def _draw(duration: Expression, place: Place) -> float:
    value = evaluate(duration, place.environment())
    if isinstance(value, Range):
        return place.services.random(f"{place.path} {place.parent}").uniform(value.low, value.high)
    assert isinstance(value, int | float)
    return value


def _arm(specification: OnEvent, waiter: Waiter, place: Place) -> None:
    condition, name, event = specification.condition, specification.name, specification.event
    assert condition is None or isinstance(condition, Holds), "others are refused before the run"
    assert isinstance(event, DeclaredEvent | PhaseEvent), "others are refused before the run"

    def accepts(occurrence: Occurrence) -> bool:
        """Called between rounds, when no flow is there to take an exception."""
        if condition is None:
            return True
        try:
            return bool(evaluate(condition.condition, place.environment({name: occurrence} if name else {})))
        except EvaluationError as error:
            place.services.decide(RunStatus.ERROR, str(error), error.span)
            return False

    place.services.events.arm(place.instance.event(event), waiter, accepts)
