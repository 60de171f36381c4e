"""The records that behaviors leave in the trace."""

from __future__ import annotations

from seoro.lang.plan import Behavior
from seoro.runtime.invocation import Place, name_of, type_of
from seoro.runtime.verdict import Outcome


def record_start(behavior: Behavior, place: Place) -> int:
    """Record the start of a behavior; returns its number."""
    number = place.services.new_id()
    place.services.trace.record(
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
    place.services.trace.record("behavior.end", id=number, status=outcome.status.value, reason=outcome.reason)
