"""Possible emitters of an awaited event: the `emit`s of it in the plan, and whether they were reached."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

from seoro.lang import plan as plan_
from seoro.runtime.execution.context import BehaviorScope, behaviors_of
from seoro.runtime.explain.readings import short
from seoro.runtime.explanation import Emitter, OngoingBehavior

if TYPE_CHECKING:
    from seoro.runtime.execution.services import Services

_MOST = 5  # of one event

Declaration = plan_.Scenario | plan_.Action


class _Found(NamedTuple):
    """An `emit`, or a labelled member, with its enclosing behaviors from the outermost."""

    behavior: plan_.Behavior
    around: tuple[plan_.Behavior, ...]


def emitters_of(
    reference: plan_.EventReference, declaration: Declaration, services: Services
) -> tuple[Emitter, ...]:
    """Return the possible emitters of an event in the plan.

    Args:
        reference: Event, in the scope of a scenario or an action.
        declaration: The scenario or action.
        services: Services of the run.
    """
    found = list(_find(reference, declaration, services.plan))[:_MOST]
    root = services.root
    tasks = sorted((root, *root.descendants()), key=lambda task: task.path) if root is not None else []
    stacks = [behaviors_of(task)[::-1] for task in tasks]
    open_ = {id(each.behavior): (each, stack) for stack in stacks for each in stack}
    return tuple(_emitter(each, services, open_) for each in found)


def _find(reference: plan_.EventReference, declaration: Declaration, plan: plan_.Plan) -> Iterator[_Found]:
    match reference:
        case plan_.DeclaredEvent(name):
            yield from _emits(name, declaration, plan)
        case plan_.PhaseEvent(label) if label is not None:
            yield from (found for found in _members(declaration) if found.behavior.label == label)
        case plan_.LabelEvent(label, event):
            for found in _members(declaration):
                if found.behavior.label == label:
                    yield from _find_invoked(event, found.behavior, plan)
        case plan_.PhaseEvent() | plan_.MemberEvent():
            return


def _find_invoked(event: plan_.EventReference, behavior: plan_.Behavior, plan: plan_.Plan) -> Iterator[_Found]:
    match behavior:
        case plan_.InvokeScenario(scenario=name):
            yield from _find(event, plan.scenarios[name], plan)
        case plan_.InvokeAction(action=name):
            yield from _find(event, plan.actions[name], plan)
        case _:
            return


def _emits(name: str, declaration: Declaration, plan: plan_.Plan) -> Iterator[_Found]:
    """Yield the `emit`s of an event in a scenario or action, its bases and its derived declarations."""
    family = {declaration.name, *declaration.bases}
    others: list[Declaration] = [*plan.scenarios.values(), *plan.actions.values()]
    for other in others:
        if other.name not in family and declaration.name not in other.bases:
            continue
        reactions = [_Found(member, ()) for on in other.on for member in on.members]
        for found in (*_members(other), *reactions):
            match found.behavior:
                case plan_.Emit(event=plan_.DeclaredEvent(emitted)) if emitted == name:
                    yield found


def _members(declaration: Declaration) -> Iterator[_Found]:
    body = declaration.body if isinstance(declaration, plan_.Scenario) else None
    if body is not None:
        yield from _inside(body, ())


def _inside(behavior: plan_.Behavior, around: tuple[plan_.Behavior, ...]) -> Iterator[_Found]:
    yield _Found(behavior, around)
    if isinstance(behavior, plan_.Serial | plan_.Parallel | plan_.OneOf):
        for member in behavior.members:
            yield from _inside(member, (*around, behavior))


def _emitter(
    found: _Found, services: Services, open_: dict[int, tuple[BehaviorScope, list[BehaviorScope]]]
) -> Emitter:
    behavior = found.behavior
    text = short(behavior.span.text) if isinstance(behavior, plan_.Emit) else f"the end of `{behavior.label}`"
    time = services.emitted.get(id(behavior))
    return Emitter(text, behavior.span, time, _before(found, open_) if time is None else None)


def _before(found: _Found, open_: dict[int, tuple[BehaviorScope, list[BehaviorScope]]]) -> OngoingBehavior | None:
    """Return the behavior that must end before an emitter is reached: itself, or in the nearest `serial`."""
    for each in (found.behavior, *reversed(found.around)):
        if id(each) in open_:
            running, stack = open_[id(each)]
            is_known = each is found.behavior or isinstance(each, plan_.Serial)
            return ongoing(stack[-1] if isinstance(each, plan_.Serial) else running) if is_known else None
    return None


def ongoing(running: BehaviorScope) -> OngoingBehavior:
    """Convert a running behavior into data."""
    behavior, context = running.behavior, running.context
    match behavior:
        case plan_.Serial() | plan_.Parallel() | plan_.OneOf():
            text = behavior.label or type(behavior).__name__.lower()
        case plan_.InvokeScenario() | plan_.InvokeAction():
            text = context.path.rpartition("/")[2].partition("[")[0]
        case _:
            text = short(behavior.span.text)
    return OngoingBehavior(text, behavior.span, context.path, running.since)
