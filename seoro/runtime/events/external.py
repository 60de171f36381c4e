"""Events that an application emits while a scenario runs; declared before the run. Names of all events of a run.

Events of the entry scenario are named as in the scenario (`operator_ready`) or in the trace
(`main.operator_ready`), those of an actor with the actor (`robot.released`).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

from seoro.errors import UsageError
from seoro.lang.frozen import Frozen
from seoro.lang.plan import Declaration, Event, ObjectType, Phase, Plan, Scenario, behaviors_in
from seoro.runtime.contracts.backends import BACKEND_EVENTS
from seoro.runtime.events.occurrence import without_attempts
from seoro.runtime.expressions.evaluation import evaluate
from seoro.runtime.instances.instances import Instance
from seoro.runtime.values.environment import Environment, EvaluationError
from seoro.runtime.values.given import InvalidValue, given_value, type_text
from seoro.runtime.values.values import Actor, Value

_PHASES = tuple(phase.value for phase in Phase)


class ExternalEvent(Frozen):
    """An event that an application may emit.

    Args:
        name: Its name in the trace.
        declared: Its declaration.
        actor: Actor that has it; None for the entry scenario.
    """

    name: str
    declared: Event
    actor: Actor | None


class Emission(NamedTuple):
    """An event with checked arguments."""

    event: ExternalEvent
    arguments: Mapping[str, Value]


class ExternalEvents:
    """Events that the application of a run may emit.

    Args:
        plan: The plan.
        entry: Instance of the entry scenario.
        names: Names of the events, as given by the application.

    Raises:
        UsageError: An event is unknown to the entry scenario and its actors.
    """

    def __init__(self, plan: Plan, entry: Instance, names: Iterable[str]) -> None:
        self._plan = plan
        self._entry = entry
        self._actors = dict(actors_in(entry))
        self._declared = {event.name: event for event in self._all()}
        self._external = {event.name: event for event in map(self._find, names)}

    @property
    def names(self) -> tuple[str, ...]:
        """Trace names of the events, in the given order."""
        return tuple(self._external)

    def emission(self, name: str, given: Mapping[str, object], scope: Environment) -> Emission:
        """Check an event and its arguments; return the emission.

        Args:
            name: The name of the event.
            given: Its arguments as plain values; see `seoro.runtime.values.given`.
            scope: Environment of the current instance of the entry scenario, for defaults.

        Raises:
            UsageError: The event is unknown or not external, or arguments are unknown, missing or invalid.
        """
        event = self._find(name)
        if event.name not in self._external:
            known = ", ".join(f"`{each}`" for each in self._external) or "none"
            raise UsageError(
                f"event `{name}` is not external: it was not declared before the run (external events: {known})",
                help=f'start the run with `external=["{name}"]`',
            )
        return Emission(event, self._arguments(event, given, scope))

    def _arguments(
        self, event: ExternalEvent, given: Mapping[str, object], scope: Environment
    ) -> dict[str, Value]:
        declared = event.declared
        types = {name: type_ for (name, _), type_ in zip(declared.parameters, declared.types, strict=True)}
        for name in given:
            if name not in types:
                known = ", ".join(f"`{each}`" for each in types) or "none"
                raise UsageError(f"unknown field `{name}` of event `{event.name}` (fields: {known})")
        found: dict[str, Value] = {}
        if event.actor is not None:
            scope = replace(scope, instance=event.actor, bindings={}, scenario=scope.outermost)
        for name, default in declared.parameters:
            if name in given:
                try:
                    found[name] = given_value(given[name], types[name], self._plan.structures, self._actors)
                except InvalidValue as error:
                    raise UsageError(f"invalid field `{name}` of event `{event.name}`: {error}") from None
                continue
            if default is None:
                raise UsageError(
                    f"missing field `{name}` of event `{event.name}`: expected {type_text(types[name])}"
                )
            try:
                found[name] = evaluate(default, scope)
            except EvaluationError as error:
                raise UsageError(f"the default of field `{name}` has no value: {error}", error.span) from error
        return found

    def _find(self, name: str) -> ExternalEvent:
        path, name = self._entry.path, without_attempts(name)
        found = self._declared.get(name) or self._declared.get(f"{path}.{name}")
        if found is not None:
            return found
        if name.removeprefix(f"{path}.") in _PHASES:
            raise UsageError(
                f"event `{name}` is predefined and cannot be emitted from outside", help="to end a run, use `stop`"
            )
        known = [each.removeprefix(f"{path}.") for each in self._declared]
        listed = ", ".join(f"`{each}`" for each in known) or "none"
        raise UsageError(
            f"unknown event `{name}` (events of the entry scenario `{path}` and its actors: {listed})"
        )

    def _all(self) -> Iterator[ExternalEvent]:
        entry = self._entry
        for event in entry.declaration.events:
            yield ExternalEvent(f"{entry.path}.{event.name}", event, None)
        for actor in self._actors.values():
            for event in events_of(self._plan, actor.types):
                yield ExternalEvent(f"{actor.name}.{event.name}", event, actor)


def actors_in(entry: Instance) -> Iterator[tuple[str, Actor]]:
    """Yield the actors of an entry scenario by name, including those in fields of actors."""
    pending = list(entry.fields.values())
    while pending:
        value = pending.pop(0)
        if isinstance(value, Actor):
            yield value.name, value
            pending += value.fields.values()


def events_of(plan: Plan, types: Iterable[str]) -> tuple[Event, ...]:
    """Return the events of a struct or an actor; its nearest type has all of them."""
    declared = plan.object_type(types)
    return declared.events if declared is not None else ()


def trace_name(name: str, plan: Plan, entry: Instance, has_backends: bool) -> str:
    """Return the name of an event in the trace.

    Args:
        name: As in the entry scenario (`go`, `x.end`, `robot.arrived`) or in traces (`main.go`).
        plan: The plan.
        entry: Instance of the entry scenario.
        has_backends: Whether simulators or robots take part, which report events.

    Raises:
        UsageError: The run cannot have such an event.
    """
    name, path = without_attempts(name), entry.path
    own = dict.fromkeys((*_PHASES, *_names(entry.declaration), *_of_labels(plan.scenarios[plan.entry])))
    actors = [f"{name}.{event.name}" for name, actor in actors_in(entry) for event in events_of(plan, actor.types)]
    of_types = [f"{name}.{event}" for name, each in plan.objects.items() for event in _names(each)]
    others = dict.fromkeys((*actors, *of_types, *(BACKEND_EVENTS if has_backends else ())))
    if name in others:
        return name
    for known in own:
        if name in (known, f"{path}.{known}"):
            return f"{path}.{known}"
    if name.startswith(f"{path}/") and name.rpartition("].")[2] in _inner_names(plan):
        return name
    listed = ", ".join(f"`{each}`" for each in (*own, *others))
    raise UsageError(f"unknown event `{name}` (events of this run: {listed})")


def _inner_names(plan: Plan) -> set[str]:
    """Return the names of events of invoked scenarios, actions and modifiers, without paths."""
    declared = (*plan.scenarios.values(), *plan.actions.values(), *plan.modifiers.values())
    labelled = (name for scenario in plan.scenarios.values() for name in _of_labels(scenario))
    return {*_PHASES, *(name for each in declared for name in _names(each)), *labelled}


def _names(declared: Declaration | ObjectType) -> Iterator[str]:
    return (event.name for event in declared.events)


def _of_labels(scenario: Scenario) -> Iterator[str]:
    """Yield the names of the predefined events of labelled behaviors."""
    labels = (behavior.label for behavior in behaviors_in(scenario.body))
    return (f"{label}.{phase}" for label in labels if label for phase in _PHASES)
