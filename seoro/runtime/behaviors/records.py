"""Trace records of behaviors."""

from __future__ import annotations

from seoro.lang.plan import Behavior
from seoro.runtime.execution.context import ExecutionContext
from seoro.runtime.execution.names import name_of, type_of
from seoro.runtime.execution.services import Services
from seoro.runtime.execution.static_tree import place
from seoro.runtime.instances.instances import Instance
from seoro.runtime.instances.times import DURATION
from seoro.runtime.kernel.task import CausalPast
from seoro.runtime.verdict import Outcome


def record_start(behavior: Behavior, context: ExecutionContext, past: CausalPast) -> int:
    """Record the start of a behavior; return its number.

    Args:
        behavior: The behavior.
        context: Its context.
        past: Past of its task or reaction; the record becomes the cause of the next ones.
    """
    services = context.services
    number = services.new_id()
    if not services.trace.is_observed:
        return number
    known = services.places.get(id(behavior))
    past.cause = services.trace.record(
        "behavior.start",
        past.cause,
        id=number,
        parent=context.number,
        type=type_of(behavior),
        name=name_of(behavior),
        path=context.path,
        **(place(behavior.span) if known is None else known),
    )
    return number


def record_end(number: int, outcome: Outcome, services: Services, past: CausalPast) -> None:
    """Record the end of a behavior.

    Args:
        number: Its number.
        outcome: Its outcome.
        services: Services of the run.
        past: Past of its task or reaction; the record becomes the cause of the next ones.
    """
    if services.trace.is_observed:
        past.cause = services.trace.record(
            "behavior.end", past.cause, id=number, status=outcome.status.value, reason=outcome.reason
        )


def record_instance(instance: Instance, behavior: int | None, services: Services) -> None:
    """Record the values of a new instance, except its times.

    Args:
        instance: The instance.
        behavior: Number of the invoking behavior.
        services: Services of the run.
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
    """Whether a field of an instance is the added `duration` of `it` rather than a declared one."""
    return name == DURATION and name not in instance.declaration.structure.fields
