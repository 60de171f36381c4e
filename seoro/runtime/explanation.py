"""Why a behavior or a run ended as it did, as data: what was waited for, with its values, and what was going on.

It is a picture of the instant in which that was decided; values are those of that instant. Times are in seconds of
the run's clock. `seoro.reasons` shows it to people.
"""

from __future__ import annotations

from enum import Enum
from typing import Any

from seoro.lang.frozen import Value
from seoro.lang.source import Span


class Reading(Value):
    """What stood in a condition or an argument, and its value.

    Args:
        text: As the scenario writes it, or the name of a parameter.
        value: As JSON knows it; in SI base units.
        unit: Of a physical value, such as `m/s`; empty for others.
        error: Why it had no value; empty if it had one.
        shown: The value as the language writes it, such as `2.5mps`.
    """

    text: str
    value: object
    unit: str = ""
    error: str = ""
    shown: str = ""

    def plain(self) -> dict[str, Any]:
        """For JSON."""
        found = {"text": self.text, "value": self.value, "unit": self.unit, "shown": self.shown}
        return {"text": self.text, "error": self.error} if self.error else found


class Doing(Value):
    """A behavior that was going on: what it is, where it stands, since when."""

    text: str
    span: Span
    path: str
    since: float

    def plain(self) -> dict[str, Any]:
        """For JSON."""
        return {"text": self.text, "source": str(self.span), "path": self.path, "since": self.since}


class Emitter(Value):
    """What in the plan would make an awaited event occur.

    Args:
        text: As the scenario writes it.
        span: Its place.
        time: When it did last; None if it never has.
        after: What has to end before it is reached for the first time; None if nothing is known of that.
    """

    text: str
    span: Span
    time: float | None
    after: Doing | None

    def plain(self) -> dict[str, Any]:
        """For JSON."""
        after = self.after.plain() if self.after is not None else None
        return {"text": self.text, "source": str(self.span), "last": self.time, "after": after}


class Kind(Enum):
    """What a flow of control was doing."""

    WAITS = "waits"
    RUNS = "runs"
    HOLDS = "holds"  # its work is done, and what ends it has not come


class Activity(Value):
    """What one flow of control was doing.

    Args:
        kind: Waiting for something, carrying out an action, or held.
        doing: The behavior.
        due: When it would have gone on by itself [s]; None if that is not known.
        readings: The values of the condition it waited for, or of the action's arguments.
        event: The event that it waited for; empty if it waited for none.
        emitters: What would emit that.
    """

    kind: Kind
    doing: Doing
    due: float | None = None
    readings: tuple[Reading, ...] = ()
    event: str = ""
    emitters: tuple[Emitter, ...] = ()

    def plain(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "kind": self.kind.value,
            **self.doing.plain(),
            "due": self.due,
            "values": [reading.plain() for reading in self.readings],
            "event": self.event,
            "emitters": [emitter.plain() for emitter in self.emitters],
        }


class Explanation(Value):
    """The picture of an instant.

    Args:
        time: When [s].
        path: Of the behavior that ended; empty for the whole run.
        readings: Values of what failed by itself, such as the arguments of an action.
        activities: What went on then, in the order of starts.
        more: How many more activities there were.
    """

    time: float
    path: str
    readings: tuple[Reading, ...] = ()
    activities: tuple[Activity, ...] = ()
    more: int = 0

    def plain(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "t": self.time,
            "path": self.path,
            "values": [reading.plain() for reading in self.readings],
            "activities": [activity.plain() for activity in self.activities],
            "more": self.more,
        }
