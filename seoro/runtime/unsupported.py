"""What a plan may hold and the runtime cannot carry out yet: refused by name before anything runs.

An entry disappears with the support for it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple, assert_never

from seoro.errors import InvalidUse
from seoro.lang.plan import (
    Behavior,
    Binding,
    CallMethod,
    Constraint,
    Emit,
    Event,
    EventSpecification,
    Every,
    Expression,
    Fall,
    FieldDeclaration,
    InvokeAction,
    InvokeScenario,
    Member,
    Modification,
    Modifier,
    ModifierApplication,
    On,
    OneOf,
    OnEvent,
    Override,
    Parallel,
    Plan,
    Rise,
    Sample,
    Serial,
    Until,
    Wait,
    modifier_type,
    parts,
)
from seoro.lang.source import Span

_TIMES = frozenset({"duration", "overlap", "start_to_start", "end_to_end"})


class _Refused(NamedTuple):
    """A construct, as people call it, and where it stands."""

    what: str
    span: Span


def refuse_unsupported(plan: Plan) -> None:
    """Refuse a plan with anything that the runtime cannot carry out.

    Raises:
        InvalidUse: There is such a construct; the message names each, and shows each in its place.
    """
    found = list(dict.fromkeys(_of_plan(plan)))
    if found:
        named = ", ".join(dict.fromkeys(what for what, _ in found))
        places = tuple((span, f"{what} is not carried out yet") for what, span in found)
        raise InvalidUse(f"this is checked, but cannot be carried out yet: {named}", found[0].span, places=places)


def _of_plan(plan: Plan) -> Iterator[_Refused]:
    for scenario in plan.scenarios.values():
        yield from _of_members(scenario.events, scenario.on, scenario.samples)
        yield from _of_modifications(scenario.modifiers)
        if scenario.body is not None:
            yield from _of_behavior(scenario.body, plan)
    for action in plan.actions.values():
        yield from _of_members(action.events, action.on, action.samples)
        yield from _of_modifications(action.modifiers)
    for type_ in plan.objects.values():
        yield from _of_members(type_.events, (), type_.samples)
        for applied in type_.modifiers:
            yield _Refused("a modifier of a struct or an actor", applied.span)
    for name, modifier in plan.modifiers.items():
        yield from _of_modifier(modifier, plan)
        for item in plan.coverage.get(modifier_type(name), ()):
            yield _Refused("`cover` or `record` in a modifier", item.span)


def _of_members(
    events: Iterable[Event], directives: Iterable[On], samples: Iterable[Sample]
) -> Iterator[_Refused]:
    for event in events:
        if event.specification is not None:
            yield from _of_specification(event.specification)
    for directive in directives:
        yield from _of_specification(directive.event)
    for sample in samples:
        yield from _of_specification(sample.event)


def _of_modifier(modifier: Modifier, plan: Plan) -> Iterator[_Refused]:
    yield from _of_times_of_it(modifier, plan)
    for event in modifier.events:
        yield _Refused("an event of a modifier", event.span)
    for directive in modifier.on:
        yield _Refused("`on` in a modifier", directive.span)
    for sample in modifier.samples:
        yield _Refused("`sample` in a modifier", sample.span)


def _of_times_of_it(modifier: Modifier, plan: Plan) -> Iterator[_Refused]:
    """Times of what is modified, which are arguments of it, and no fields."""
    modified = plan.scenarios.get(modifier.of or "") or plan.actions.get(modifier.of or "")
    fields = modified.structure.fields if modified is not None else {}
    pending: list[Expression] = []
    for member in modifier.structure.members:
        match member:
            case FieldDeclaration(default=default) if default is not None:
                pending.append(default)
            case Constraint(condition):
                pending.append(condition)
            case _:
                pass
    for applied in modifier.modifiers:
        if isinstance(applied, ModifierApplication):
            pending += [value for _, value in (*applied.arguments, *applied.ranges)]
    while pending:
        part = pending.pop()
        if isinstance(part, Member) and part.name in _TIMES - fields.keys() and isinstance(part.base, Binding):
            yield _Refused(f"`it.{part.name}` in a modifier", part.span)
        pending += parts(part)


def _of_behavior(first: Behavior, plan: Plan) -> Iterator[_Refused]:
    stack = [first]
    while stack:
        behavior = stack.pop()
        match behavior:
            case Serial() | Parallel() | OneOf():
                yield from (_Refused("a constraint on a composition", each.span) for each in behavior.constraints)
                yield from _of_modifications(behavior.modifications)
                stack += reversed(behavior.members)
            case InvokeAction() | InvokeScenario():
                yield from _of_constraints(behavior, plan)
                yield from _of_modifications(behavior.modifications)
            case Wait(event=event):
                yield from _of_specification(event)
            case Emit() | CallMethod():
                pass
            case _:
                assert_never(behavior)


def _of_constraints(behavior: InvokeAction | InvokeScenario, plan: Plan) -> Iterator[_Refused]:
    """Constraints on the `duration` that every invocation has, and that is no field."""
    if isinstance(behavior, InvokeAction):
        fields = plan.actions[behavior.action].structure.fields
    else:
        fields = plan.scenarios[behavior.scenario].structure.fields
    for constraint in behavior.constraints if "duration" not in fields else ():
        pending = [constraint.condition if isinstance(constraint, Constraint) else constraint.parameter]
        while pending:
            part = pending.pop()
            if isinstance(part, Member) and part.name == "duration" and isinstance(part.base, Binding):
                yield _Refused("a constraint on `duration`", part.span)
            pending += parts(part)


def _of_modifications(modifications: Iterable[Modification]) -> Iterator[_Refused]:
    for modification in modifications:
        match modification:
            case Until(event):
                yield from _of_specification(event)
            case ModifierApplication() | Override():
                pass
            case _:
                assert_never(modification)


def _of_specification(event: EventSpecification) -> Iterator[_Refused]:
    """A change cannot be watched of what is not known before the event."""
    match event:
        case OnEvent(_, str() as name, Rise(condition) | Fall(condition)):
            if _uses(condition, name):
                yield _Refused("an occurrence in `rise` or `fall`", condition.span)
        case OnEvent(_, str() as name, Every(period, offset)):
            for expression in (period, offset):
                if expression is not None and _uses(expression, name):
                    yield _Refused("an occurrence in `every`", expression.span)
        case _:
            pass


def _uses(expression: Expression, binding: str) -> bool:
    """Whether an expression uses what is bound to a name."""
    if isinstance(expression, Binding):
        return expression.name == binding
    return any(_uses(part, binding) for part in parts(expression))
