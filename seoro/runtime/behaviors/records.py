"""The records that behaviors leave in the trace."""

from __future__ import annotations

from seoro.lang.plan import Behavior
from seoro.runtime.choose.times import DURATION
from seoro.runtime.instances import Instance
from seoro.runtime.place import Place, name_of, type_of
from seoro.runtime.services import Running, Services
from seoro.runtime.verdict import Outcome


def record_start(behavior: Behavior, place: Place) -> int:
    """Record the start of a behavior; returns its number."""
    services = place.services
    number = services.new_id()
    services.running.setdefault(place.flow, []).append(Running(behavior, place, services.agenda.now))
    if not services.trace.is_observed:
        return number
    services.trace.record(
        "behavior.start",
        id=number,
        parent=place.parent,
        type=type_of(behavior),
        name=name_of(behavior),
        path=place.path,
        source=str(behavior.span),
    )
    return number


def record_end(number: int, outcome: Outcome, place: Place) -> None:
    """Record the end of the behavior with that number."""
    services = place.services
    stack = services.running[place.flow]
    stack.pop()
    if not stack:
        del services.running[place.flow]
    if services.trace.is_observed:
        services.trace.record("behavior.end", id=number, status=outcome.status.value, reason=outcome.reason)


def record_instance(instance: Instance, behavior: int | None, services: Services) -> None:
    """Record the values of a new instance, apart from those of its times.

    Args:
        instance: The instance.
        behavior: Number of the behavior that invokes it.
        services: Of the run.
    """
    trace = services.trace
    if trace.is_observed:
        exact = trace.exact
        fields = {"instance": exact.number(instance), "of": instance.declaration.name, "path": instance.path}
        if instance.actor is not None:
            fields["actor"] = exact.value(instance.actor)
        declared = {name: value for name, value in instance.fields.items() if not _is_time(name, instance)}
        trace.record("instance", behavior=behavior, **fields, values=exact.fields(declared))


def _is_time(name: str, instance: Instance) -> bool:
    """Whether a field of an instance is none of its declaration, but what `it` has for its duration."""
    return name == DURATION and name not in instance.declaration.structure.fields
