"""Explanation of an outcome or verdict as data: conditions with their values, and current activities.

It describes the instant of the decision, with the values of that instant. Times are in seconds of the run's clock.
`seoro.runtime.explain.reasons` formats it as text.
"""

from __future__ import annotations

from enum import Enum
from typing import Any

from seoro.lang.frozen import Value
from seoro.lang.source import Span


class Reading(Value):
    """An expression in a condition or an argument, with its value.

    Args:
        text: Text in the scenario, or the name of a parameter.
        value: Value for JSON, in SI base units.
        unit: Unit of a physical value, such as `m/s`; empty for others.
        error: Reason why it has no value; empty if it has one.
        shown: Value as written in the language, such as `2.5mps`.
    """

    text: str
    value: object
    unit: str = ""
    error: str = ""
    shown: str = ""

    def plain(self) -> dict[str, Any]:
        """Return the fields for JSON."""
        found = {"text": self.text, "value": self.value, "unit": self.unit, "shown": self.shown}
        return {"text": self.text, "error": self.error} if self.error else found


class OngoingBehavior(Value):
    """A running behavior: its text, location and start time."""

    text: str
    span: Span
    path: str
    since: float

    def plain(self) -> dict[str, Any]:
        """Return the fields for JSON."""
        return {"text": self.text, "source": str(self.span), "path": self.path, "since": self.since}


class Emitter(Value):
    """An element of the plan that would emit an awaited event.

    Args:
        text: Text in the scenario.
        span: Its location.
        time: Time of its last emission; None if it has not emitted.
        after: Behavior that must end before it is reached for the first time; None if unknown.
    """

    text: str
    span: Span
    time: float | None
    after: OngoingBehavior | None

    def plain(self) -> dict[str, Any]:
        """Return the fields for JSON."""
        after = self.after.plain() if self.after is not None else None
        return {"text": self.text, "source": str(self.span), "last": self.time, "after": after}


class Kind(Enum):
    """Kinds of activities."""

    WAITS = "waits"
    RUNS = "runs"
    HOLDS = "holds"  # its work is done, and it waits to be ended


class Activity(Value):
    """Current activity of one task.

    Args:
        kind: Waiting, running an action, or holding.
        ongoing: The behavior.
        due: Time at which it would continue by itself [s]; None if unknown.
        readings: Values of its condition, or of the arguments of its action.
        event: Awaited event; empty if none.
        emitters: Emitters of that event.
    """

    kind: Kind
    ongoing: OngoingBehavior
    due: float | None = None
    readings: tuple[Reading, ...] = ()
    event: str = ""
    emitters: tuple[Emitter, ...] = ()

    def plain(self) -> dict[str, Any]:
        """Return the fields for JSON."""
        return {
            "kind": self.kind.value,
            **self.ongoing.plain(),
            "due": self.due,
            "values": [reading.plain() for reading in self.readings],
            "event": self.event,
            "emitters": [emitter.plain() for emitter in self.emitters],
        }


class Explanation(Value):
    """Description of an instant.

    Args:
        time: Time of the instant [s].
        path: Path of the behavior that ended; empty for the run.
        readings: Values of the behavior that failed by itself, such as the arguments of an action.
        activities: Current activities, in order of their starts.
        more: Number of omitted activities.
    """

    time: float
    path: str
    readings: tuple[Reading, ...] = ()
    activities: tuple[Activity, ...] = ()
    more: int = 0

    def plain(self) -> dict[str, Any]:
        """Return the fields for JSON."""
        return {
            "t": self.time,
            "path": self.path,
            "values": [reading.plain() for reading in self.readings],
            "activities": [activity.plain() for activity in self.activities],
            "more": self.more,
        }
