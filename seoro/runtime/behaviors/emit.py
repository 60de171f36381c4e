"""`emit` (7.3.10.2): an event occurs. Of the enclosing scenario's own `end` and `fail`, this ends the scenario.

It takes no time, and takes hold between this round and the next.
"""

from __future__ import annotations

from functools import partial

from seoro.lang.plan import DeclaredEvent, Emit, Phase, PhaseEvent
from seoro.runtime.agenda import Scope
from seoro.runtime.environment import Environment
from seoro.runtime.evaluate import evaluate
from seoro.runtime.explain import explained
from seoro.runtime.past import Past
from seoro.runtime.place import Place
from seoro.runtime.values import Value
from seoro.runtime.verdict import SUCCEEDED, Outcome, failure


def run_emit(plan: Emit, place: Place, environment: Environment, past: Past) -> Outcome:
    """Carry it out.

    Args:
        plan: What is emitted.
        place: Where.
        environment: What names stand for there.
        past: Of who emits; the occurrence is in it from then on.
    """
    event = plan.event
    place.services.emitted[id(plan)] = place.agenda.now
    if isinstance(event, PhaseEvent) and event.label is None and event.phase is not Phase.START:
        scope = place.instance.scope
        assert scope is not None, "its scenario is running"
        place.agenda.after_round(place.position, partial(_end, scope, plan, place))
        return SUCCEEDED
    arguments: dict[str, Value] = {}
    if isinstance(event, DeclaredEvent):
        declared = place.instance.events[event.name]
        given = declared.all_arguments(plan.arguments)
        arguments = {name: evaluate(given[name], environment) for name, _ in declared.parameters}
    place.services.events.emit(place.instance.event(event), arguments, past)
    return SUCCEEDED


def _end(scope: Scope, plan: Emit, place: Place) -> None:
    """End the enclosing scenario; what explains a failure is what goes on after this round."""
    is_failed = isinstance(plan.event, PhaseEvent) and plan.event.phase is Phase.FAIL
    outcome = explained(failure("`emit fail`", plan.span), place, scope) if is_failed else SUCCEEDED
    place.agenda.end(scope, outcome)
