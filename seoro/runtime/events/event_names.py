"""Names of the events that a run may record in its trace, for subscribers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from seoro.errors import UsageError
from seoro.lang.plan import Behavior, OneOf, Parallel, Phase, Plan, Serial
from seoro.runtime.contracts.backends import BACKEND_EVENTS
from seoro.runtime.events.external import actors_in, events_of
from seoro.runtime.events.occurrence import without_attempts
from seoro.runtime.instances.instances import Instance

_PHASES = tuple(phase.value for phase in Phase)


class EventNames:
    """The events of a run by name.

    Args:
        plan: The plan.
        entry: Instance of the entry scenario.
        has_backends: Whether simulators or robots take part, which report events.
    """

    def __init__(self, plan: Plan, entry: Instance, has_backends: bool) -> None:
        self._plan = plan
        self._path = entry.path
        own = [*_PHASES, *(event.name for event in entry.declaration.events)]
        labelled = [f"{label}.{phase}" for label in _labels(_body(plan)) for phase in _PHASES]
        self._own = dict.fromkeys((*own, *labelled))
        actors = [
            f"{name}.{event.name}" for name, actor in actors_in(entry) for event in events_of(plan, actor.types)
        ]
        of_types = [f"{name}.{event.name}" for name, each in plan.objects.items() for event in each.events]
        self._others = dict.fromkeys((*actors, *of_types, *(BACKEND_EVENTS if has_backends else ())))

    def find(self, name: str) -> str:
        """Return the name of an event in the trace.

        Args:
            name: As in the entry scenario (`go`, `x.end`, `robot.arrived`) or in traces (`main.go`).

        Raises:
            UsageError: The run cannot have such an event.
        """
        name = without_attempts(name)
        if name in self._others:
            return name
        for known in self._own:
            if name in (known, f"{self._path}.{known}"):
                return f"{self._path}.{known}"
        if name.startswith(f"{self._path}/") and name.rpartition("].")[2] in self._inner():
            return name
        listed = ", ".join(f"`{each}`" for each in (*self._own, *self._others))
        raise UsageError(f"unknown event `{name}` (events of this run: {listed})")

    def _inner(self) -> set[str]:
        """Return the names of events of invoked scenarios, actions and modifiers, without paths."""
        plan, found = self._plan, set(_PHASES)
        for scenario in plan.scenarios.values():
            found.update(event.name for event in scenario.events)
            found.update(f"{label}.{phase}" for label in _labels([scenario.body]) for phase in _PHASES)
        for action in plan.actions.values():
            found.update(event.name for event in action.events)
        for modifier in plan.modifiers.values():
            found.update(event.name for event in modifier.events)
        return found


def _body(plan: Plan) -> list[Behavior | None]:
    return [plan.scenarios[plan.entry].body]


def _labels(behaviors: Sequence[Behavior | None]) -> Iterator[str]:
    """Yield the labels of behaviors."""
    for behavior in behaviors:
        if behavior is not None and behavior.label:
            yield behavior.label
        if isinstance(behavior, Serial | Parallel | OneOf):
            yield from _labels(behavior.members)
