"""Who could make an event occur that is waited for: the `emit`s of it in the plan, and how far they are."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

from seoro.lang.plan import (
    Action,
    Behavior,
    DeclaredEvent,
    Emit,
    EventReference,
    InvokeAction,
    InvokeScenario,
    LabelEvent,
    MemberEvent,
    OneOf,
    Parallel,
    PhaseEvent,
    Plan,
    Scenario,
    Serial,
)
from seoro.runtime.explanation import Doing, Emitter
from seoro.runtime.readings import short

if TYPE_CHECKING:
    from seoro.runtime.services import Running, Services

_MOST = 5  # of one event

Declaration = Scenario | Action


class _Found(NamedTuple):
    """An `emit`, or a labelled member, with the behaviors around it, the outermost first."""

    behavior: Behavior
    around: tuple[Behavior, ...]


def emitters_of(reference: EventReference, declaration: Declaration, services: Services) -> tuple[Emitter, ...]:
    """What could make an event occur, as far as the plan tells.

    Args:
        reference: The event, in the scope of a scenario or an action.
        declaration: That scenario or action.
        services: Of the run.
    """
    found = list(_find(reference, declaration, services.plan))[:_MOST]
    stacks = [stack for _, stack in sorted(services.running.items(), key=lambda item: item[0].path)]
    open_ = {id(each.behavior): (each, stack) for stack in stacks for each in stack}
    return tuple(_emitter(each, services, open_) for each in found)


def _find(reference: EventReference, declaration: Declaration, plan: Plan) -> Iterator[_Found]:
    match reference:
        case DeclaredEvent(name):
            yield from _emits(name, declaration, plan)
        case PhaseEvent(label) if label is not None:
            yield from (found for found in _members(declaration) if found.behavior.label == label)
        case LabelEvent(label, event):
            for found in _members(declaration):
                if found.behavior.label == label:
                    yield from _find_invoked(event, found.behavior, plan)
        case PhaseEvent() | MemberEvent():
            return


def _find_invoked(event: EventReference, behavior: Behavior, plan: Plan) -> Iterator[_Found]:
    match behavior:
        case InvokeScenario(scenario=name):
            yield from _find(event, plan.scenarios[name], plan)
        case InvokeAction(action=name):
            yield from _find(event, plan.actions[name], plan)
        case _:
            return


def _emits(name: str, declaration: Declaration, plan: Plan) -> Iterator[_Found]:
    """The `emit`s of an event that a scenario or an action has: in it, what inherits it, and what it inherits."""
    family = {declaration.name, *declaration.bases}
    others: list[Declaration] = [*plan.scenarios.values(), *plan.actions.values()]
    for other in others:
        if other.name not in family and declaration.name not in other.bases:
            continue
        reactions = [_Found(member, ()) for on in other.on for member in on.members]
        for found in (*_members(other), *reactions):
            match found.behavior:
                case Emit(event=DeclaredEvent(emitted)) if emitted == name:
                    yield found


def _members(declaration: Declaration) -> Iterator[_Found]:
    body = declaration.body if isinstance(declaration, Scenario) else None
    if body is not None:
        yield from _inside(body, ())


def _inside(behavior: Behavior, around: tuple[Behavior, ...]) -> Iterator[_Found]:
    yield _Found(behavior, around)
    if isinstance(behavior, Serial | Parallel | OneOf):
        for member in behavior.members:
            yield from _inside(member, (*around, behavior))


def _emitter(found: _Found, services: Services, open_: dict[int, tuple[Running, list[Running]]]) -> Emitter:
    behavior = found.behavior
    text = short(behavior.span.text) if isinstance(behavior, Emit) else f"the end of `{behavior.label}`"
    time = services.emitted.get(id(behavior))
    return Emitter(text, behavior.span, time, _before(found, open_) if time is None else None)


def _before(found: _Found, open_: dict[int, tuple[Running, list[Running]]]) -> Doing | None:
    """What has to end before something is reached: itself, or what the nearest `serial` around it is at."""
    for each in (found.behavior, *reversed(found.around)):
        if id(each) in open_:
            running, stack = open_[id(each)]
            is_known = each is found.behavior or isinstance(each, Serial)
            return doing(stack[-1] if isinstance(each, Serial) else running) if is_known else None
    return None


def doing(running: Running) -> Doing:
    """A behavior that is going on, as data."""
    behavior, place, since = running
    match behavior:
        case Serial() | Parallel() | OneOf():
            text = behavior.label or type(behavior).__name__.lower()
        case InvokeScenario() | InvokeAction():
            text = place.path.rpartition("/")[2].partition("[")[0]
        case _:
            text = short(behavior.span.text)
    return Doing(text, behavior.span, place.path, since)
