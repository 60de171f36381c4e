"""Description of a paused run: its branches with their behaviors, and their variables."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from seoro.lang import plan as plan_
from seoro.lang.frozen import Value
from seoro.lang.source import Span
from seoro.runtime.execution.context import BehaviorScope, behaviors_of
from seoro.runtime.execution.names import name_of, type_of
from seoro.runtime.explain.explain import explain
from seoro.runtime.explain.readings import short
from seoro.runtime.explain.reasons import activity_lines
from seoro.runtime.instances.instances import Instance
from seoro.runtime.values.text import value_text
from seoro.runtime.values.values import Actor, Struct

if TYPE_CHECKING:
    from seoro.runtime.execution.services import Services
    from seoro.runtime.kernel.task import Task
    from seoro.runtime.values.values import Value as RunValue


class Frame(Value):
    """A behavior that is running.

    Args:
        name: Its label, otherwise the invoked name, otherwise its kind.
        kind: Its kind, as in traces.
        span: Its span.
        since: Time of its start [s].
        scope: Its scope.
    """

    name: str
    kind: str
    span: Span
    since: float
    scope: BehaviorScope


class Branch(Value):
    """A branch of the tree of behaviors: what one innermost task does.

    Args:
        number: Number of the branch, which it keeps as long as it runs.
        path: Path of its innermost behavior.
        frames: Its behaviors, the innermost first, up to the entry scenario.
        activity: Text about its wait or its action; empty for none.
    """

    number: int
    path: str
    frames: tuple[Frame, ...]
    activity: str


class Member(Value):
    """A variable, or a part of its value.

    Args:
        name: Its name.
        text: Its value as written in the language.
        type_name: Name of its type; empty if unknown.
        value: Its value.
    """

    name: str
    text: str
    type_name: str
    value: RunValue


def branches(services: Services, numbers: dict[Task, int]) -> tuple[Branch, ...]:
    """Describe the branches of a run, in order of their starts.

    Args:
        services: Services of the run.
        numbers: Numbers of tasks, to which new ones are added.
    """
    root = services.root
    if root is None:
        return ()
    tasks = [root, *root.descendants()]
    parents = {task.parent for task in tasks[1:]}
    found: list[Branch] = []
    for task in tasks:
        if task in parents:
            continue
        frames = tuple(_frames(task))
        if frames:
            number = numbers.setdefault(task, len(numbers) + 1)
            found.append(Branch(number, frames[0].scope.context.path, frames, _activity(services, task)))
    return tuple(found)


def _frames(task: Task) -> Iterator[Frame]:
    """Yield the behaviors of a task and of the tasks around it, the innermost first."""
    at: Task | None = task
    while at is not None:
        for scope in behaviors_of(at):
            yield frame_of(scope)
        at = at.parent


def frame_of(scope: BehaviorScope) -> Frame:
    """Describe a behavior."""
    behavior = scope.behavior
    return Frame(name_of(behavior), type_of(behavior), behavior.span, scope.since, scope)


def _activity(services: Services, task: Task) -> str:
    explained = explain(services, [task], "", None).activities
    return "\n".join(activity_lines(explained[0])) if explained else ""


def variables_of(scope: BehaviorScope) -> tuple[Member, ...]:
    """Return the parameters and variables of the scenario around a behavior, by their declarations."""
    return _of_instance(scope.context.instance, scope.context.services)


def arguments_of(scope: BehaviorScope) -> tuple[Member, ...]:
    """Return the values of the parameters of what a behavior invokes; empty for others."""
    invoked = scope.context.invoked
    instance = invoked.instance if invoked is not None else None
    return _of_instance(instance, scope.context.services) if isinstance(instance, Instance) else ()


def globals_of(services: Services) -> tuple[Member, ...]:
    """Return the global parameters."""
    if services.entry is None:
        return ()
    declared, fields = services.plan.globals.fields, services.entry.instance.fields
    return _members({name: fields[name] for name in declared if name in fields}, declared, services)


def parts_of(value: RunValue, services: Services) -> tuple[Member, ...]:
    """Return the fields of a struct or an actor, and the items of a list; empty for other values."""
    match value:
        case Struct() | Actor():
            structure = services.plan.structures.find(value.type)
            return _members(value.fields, structure.fields if structure is not None else {}, services)
        case tuple():
            return tuple(
                Member(f"[{index}]", short(value_text(item, None, services.plan.structures)), "", item)
                for index, item in enumerate(value)
            )
        case _:
            return ()


def has_parts(value: RunValue) -> bool:
    """Whether `parts_of` a value may have any."""
    return isinstance(value, Struct | Actor) or (isinstance(value, tuple) and bool(value))


def _of_instance(instance: Instance, services: Services) -> tuple[Member, ...]:
    declared = instance.declaration.structure.fields
    return _members(
        {name: value for name, value in instance.fields.items() if name in declared}, declared, services
    )


def _members(
    fields: Mapping[str, RunValue], declared: Mapping[str, plan_.FieldDeclaration], services: Services
) -> tuple[Member, ...]:
    structures = services.plan.structures
    found: list[Member] = []
    for name, value in fields.items():
        type_ = declared[name].type if name in declared else None
        found.append(
            Member(name.rpartition("::")[2], short(value_text(value, type_, structures)), _type_name(type_), value)
        )
    return tuple(found)


def _type_name(type_: plan_.ValueType | None) -> str:
    return "" if type_ is None else getattr(type_, "name", type(type_).__name__)
