"""Snapshot of the activities that explain the end of a run: waits, actions and holds at that instant.

It is taken when a behavior fails or is cut off, before its cancellation. Until then, tasks only record their
current behavior, and `emit` the time when it was reached.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice
from typing import TYPE_CHECKING

from seoro.lang import plan as plan_
from seoro.runtime.execution.context import BehaviorScope, behaviors_of
from seoro.runtime.explain.emitters import emitters_of, ongoing
from seoro.runtime.explain.readings import read_arguments, read_condition, short
from seoro.runtime.explanation import Activity, Explanation, Kind, OngoingBehavior
from seoro.runtime.expressions.evaluation import evaluate

if TYPE_CHECKING:
    from seoro.lang.source import Span
    from seoro.runtime.execution.context import ExecutionContext
    from seoro.runtime.execution.services import Services
    from seoro.runtime.instances.instances import Instance
    from seoro.runtime.kernel.task import Task
    from seoro.runtime.values.environment import Environment

_MOST = 8  # activities


def explain_action(context: ExecutionContext, instance: Instance) -> Explanation:
    """Explain an action that failed by itself, by the values of its parameters."""
    services = context.services
    behaviors = behaviors_of(context.task)
    behavior = behaviors[0].behavior if behaviors else None
    invocation = behavior if isinstance(behavior, plan_.InvokeAction) else None
    names = instance.declaration.structure.fields
    return Explanation(
        services.scheduler.now, context.path, read_arguments(invocation, instance, names, services.plan)
    )


def explain(services: Services, tasks: Sequence[Task], path: str, failed: Span | None) -> Explanation:
    """Explain the activities of tasks.

    Args:
        services: Services of the run.
        tasks: Tasks, each after the one that started it.
        path: Path of their behavior.
        failed: Place of the failed behavior, which is left out.
    """
    parents = {task.parent for task in tasks[1:]}
    running = [(task, found[0]) for task in tasks if task not in parents and (found := behaviors_of(task))]
    shown = [
        (task, last)
        for task, last in running
        if not isinstance(last.behavior, plan_.Emit)
        and not (isinstance(last.behavior, plan_.InvokeAction) and last.behavior.span == failed)
    ]
    activities = tuple(
        activity for task, last in islice(shown, _MOST) for activity in _activity(task, last, services)
    )
    return Explanation(services.scheduler.now, path, (), activities, max(0, len(shown) - _MOST))


def _activity(task: Task, running: BehaviorScope, services: Services) -> Iterator[Activity]:
    behavior, context, since = running.behavior, running.context, running.since
    held = services.waits.get(task)
    match behavior:
        case plan_.Wait(event=specification):
            environment = context.environment()
            yield _awaiting(Kind.WAITS, ongoing(running), specification, environment, context, since)
        case _ if held is not None:
            what = OngoingBehavior(short(held.text), held, context.path, since)
            untils = [each for each in getattr(behavior, "modifications", ()) if isinstance(each, plan_.Until)]
            until = next((each for each in untils if each.span == held), None)
            if until is None:
                yield Activity(Kind.HOLDS, what)
            else:
                yield _awaiting(Kind.HOLDS, what, until.event, context.environment(), context, since)
        case plan_.Serial() | plan_.OneOf() | plan_.InvokeScenario() | plan_.CallMethod():
            return  # between its members
        case _:
            yield Activity(Kind.RUNS, ongoing(running))


def _awaiting(
    kind: Kind,
    what: OngoingBehavior,
    specification: plan_.EventSpecification,
    environment: Environment,
    context: ExecutionContext,
    since: float,
) -> Activity:
    """Make the activity of a wait for an event specification."""
    services, plan = context.services, context.services.plan
    if not isinstance(specification, plan_.OnEvent):
        due = _due(specification, environment, since)
        return Activity(kind, what, due, read_condition(specification, environment, plan))
    readings = read_condition(specification.condition, environment, plan) if specification.name is None else ()
    reference = specification.event
    if isinstance(reference, plan_.DeclaredEvent):
        derived = context.instance.events[reference.name].specification
        if derived is not None and not isinstance(derived, plan_.OnEvent):
            readings += read_condition(derived, environment, plan)
    declaration = context.instance.declaration
    assert not isinstance(declaration, plan_.Modifier), "modifiers have no behaviors of their own"
    emitters = emitters_of(reference, declaration, services)
    return Activity(kind, what, None, readings, short(reference.span.text), emitters)


def _due(specification: plan_.EventSpecification, environment: Environment, since: float) -> float | None:
    if not isinstance(specification, plan_.Elapsed):
        return None
    try:
        duration = evaluate(specification.duration, environment)
    except Exception:  # reported already at the start of the wait
        return None
    return round(since + duration, 9) if isinstance(duration, int | float) else None
