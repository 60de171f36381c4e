"""Taking the picture that explains an end: what was waited for, carried out and held at that instant.

It is taken when something fails or is cut off, before that is cancelled. What costs time is done for that only:
while all goes well, flows note which behavior they are in, and `emit` when it was reached.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import islice
from typing import TYPE_CHECKING

from seoro.lang.plan import (
    CallMethod,
    DeclaredEvent,
    Elapsed,
    Emit,
    EventSpecification,
    InvokeAction,
    InvokeScenario,
    Modifier,
    OneOf,
    OnEvent,
    Serial,
    Until,
    Wait,
)
from seoro.runtime.emitters import doing, emitters_of
from seoro.runtime.evaluate import evaluate
from seoro.runtime.explanation import Activity, Doing, Explanation, Kind
from seoro.runtime.readings import read_arguments, read_condition, short
from seoro.runtime.verdict import Outcome

if TYPE_CHECKING:
    from seoro.lang.source import Span
    from seoro.runtime.agenda import Flow, Scope
    from seoro.runtime.environment import Environment
    from seoro.runtime.instances import Instance
    from seoro.runtime.place import Place
    from seoro.runtime.services import Running, Services

_MOST = 8  # activities


def explained(outcome: Outcome, place: Place, scope: Scope) -> Outcome:
    """An outcome with its explanation: what goes on in a scope that is about to be ended by it."""
    if outcome.explanation is not None:
        return outcome
    return replace(outcome, explanation=explain(place.services, scope, place.path, outcome.span))


def explain_action(place: Place, instance: Instance) -> Explanation:
    """The explanation of an action that failed by itself: the values of its parameters."""
    services = place.services
    stack = services.running.get(place.flow)
    behavior = stack[-1].behavior if stack else None
    invocation = behavior if isinstance(behavior, InvokeAction) else None
    names = instance.declaration.structure.fields
    return Explanation(services.agenda.now, place.path, read_arguments(invocation, instance, names, services.plan))


def explain(services: Services, scope: Scope, path: str = "", failed: Span | None = None) -> Explanation:
    """What goes on in a scope.

    Args:
        services: Of the run.
        scope: The scope.
        path: Of the behavior that it belongs to.
        failed: The text of what failed, which is no news.
    """
    flows = [scope.flow, *scope.flows]
    forked_from = {flow.parent.flow for flow in flows[1:] if flow.parent is not None}
    running = [
        (flow, services.running[flow][-1])
        for flow in flows
        if flow not in forked_from and services.running.get(flow)
    ]
    told = [
        (flow, last)
        for flow, last in running
        if not isinstance(last.behavior, Emit)
        and not (isinstance(last.behavior, InvokeAction) and last.behavior.span == failed)
    ]
    activities = tuple(
        activity for flow, last in islice(told, _MOST) for activity in _activity(flow, last, services)
    )
    return Explanation(services.agenda.now, path, (), activities, max(0, len(told) - _MOST))


def _activity(flow: Flow, running: Running, services: Services) -> Iterator[Activity]:
    behavior, place, since = running
    held = services.waits.get(flow)
    match behavior:
        case Wait(event=specification):
            environment = place.environment()
            yield _awaiting(Kind.WAITS, doing(running), specification, environment, place, since)
        case _ if held is not None:
            what = Doing(short(held.text), held, place.path, since)
            untils = [each for each in getattr(behavior, "modifications", ()) if isinstance(each, Until)]
            until = next((each for each in untils if each.span == held), None)
            if until is None:
                yield Activity(Kind.HOLDS, what)
            else:
                yield _awaiting(Kind.HOLDS, what, until.event, place.environment(), place, since)
        case Serial() | OneOf() | InvokeScenario() | CallMethod():
            return  # between its members
        case _:
            yield Activity(Kind.RUNS, doing(running))


def _awaiting(
    kind: Kind,
    what: Doing,
    specification: EventSpecification,
    environment: Environment,
    place: Place,
    since: float,
) -> Activity:
    """What waits for an event specification."""
    services, plan = place.services, place.services.plan
    if not isinstance(specification, OnEvent):
        due = _due(specification, environment, since)
        return Activity(kind, what, due, read_condition(specification, environment, plan))
    readings = read_condition(specification.condition, environment, plan) if specification.name is None else ()
    reference = specification.event
    if isinstance(reference, DeclaredEvent):
        derived = services.declared_event(place.instance, reference.name).specification
        if derived is not None and not isinstance(derived, OnEvent):
            readings += read_condition(derived, environment, plan)
    declaration = place.instance.declaration
    assert not isinstance(declaration, Modifier), "modifiers have no behaviors of their own"
    emitters = emitters_of(reference, declaration, services)
    return Activity(kind, what, None, readings, short(reference.span.text), emitters)


def _due(specification: EventSpecification, environment: Environment, since: float) -> float | None:
    if not isinstance(specification, Elapsed):
        return None
    try:
        duration = evaluate(specification.duration, environment)
    except Exception:  # as it would have been told when the wait began
        return None
    return round(since + duration, 9) if isinstance(duration, int | float) else None
