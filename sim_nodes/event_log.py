"""Events of a simulation: pending until a grant returns them, and logged for clients that follow them.

See `seoro.bridges.wire.advance` and `seoro.bridges.wire.event_log`.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import islice

from seoro.bridges import wire
from sim_nodes.refusals import incorrect_state
from sim_nodes.stateful import Stateful
from sim_nodes.worlds.loader import World

KEPT = 10_000  # events in the log
FOLLOW_TIMEOUT = 3.0 * wire.LONGEST_WAIT  # [s] wall time without a request after which the log is not followed

WorldEvent = wire.Occurrence | wire.Contact | wire.Departure | wire.NavigationFeedback


# Fields of `LoggedEvent`.
FIELDS: Mapping[type[WorldEvent | wire.WorldChange], str] = {
    wire.Occurrence: "occurrence",
    wire.Contact: "contact",
    wire.Departure: "departure",
    wire.NavigationFeedback: "feedback",
    wire.WorldChange: "world",
}


@dataclass(frozen=True)
class CollectedEvents:
    """Events up to a time, in order."""

    occurrences: tuple[wire.Occurrence, ...]
    contacts: tuple[wire.Contact, ...]
    feedback: tuple[wire.NavigationFeedback, ...]
    departures: tuple[wire.Departure, ...] = ()


class PendingEvents(Stateful):
    """Events that were not returned yet.

    Args:
        events: The events.
    """

    STATE = ("_events",)

    def __init__(self, events: Iterable[WorldEvent] = ()) -> None:
        self._events = list(events)

    def __bool__(self) -> bool:
        return bool(self._events)

    def add(self, event: WorldEvent) -> None:
        """Add an event."""
        self._events.append(event)

    def drain(self) -> CollectedEvents:
        """Remove and return all events."""
        events, self._events = self._events, []
        return CollectedEvents(
            tuple(event for event in events if isinstance(event, wire.Occurrence)),
            tuple(event for event in events if isinstance(event, wire.Contact)),
            tuple(event for event in events if isinstance(event, wire.NavigationFeedback)),
            tuple(event for event in events if isinstance(event, wire.Departure)),
        )

    def without_feedback(self) -> PendingEvents:
        """Return the pending events except navigation feedback."""
        return PendingEvents(event for event in self._events if not isinstance(event, wire.NavigationFeedback))


class EventLog:
    """Events of a simulator across its worlds, numbered from 1.

    Attributes:
        worlds: Number of worlds so far; being without one counts as a world.
    """

    def __init__(self) -> None:
        self.worlds = 0
        self._world: World | None = None
        self._kept: deque[wire.LoggedEvent] = deque(maxlen=KEPT)
        self._number = 0
        self._requested: float | None = None

    @property
    def number(self) -> int:
        """Number of the last event."""
        return self._number

    @property
    def is_followed(self) -> bool:
        """Whether a client repeatedly requests events."""
        return self._requested is not None and time.monotonic() - self._requested < FOLLOW_TIMEOUT

    def add(self, event: WorldEvent | wire.WorldChange) -> None:
        """Log an event."""
        self._number += 1
        self._kept.append(wire.LoggedEvent.model_validate({"number": self._number, FIELDS[type(event)]: event}))

    def record_world(self, world: World | None) -> None:
        """Log a change of the world, also to none; the first world is not an event."""
        if self.worlds and world == self._world:
            return
        self._world, self.worlds = world, self.worlds + 1
        if self.worlds > 1:
            self.add(wire.WorldChange(number=self.worlds, world="" if world is None else world.name))

    def rewind(self, number: int) -> None:
        """Remove the events after a number, because the simulation was rewound."""
        while self._kept and self._kept[-1].number > number:
            self._kept.pop()
        self._number = number

    def since(self, number: int) -> wire.LoggedEvents:
        """Return the events after a number.

        Raises:
            RequestRefused: The number is in the future, or the events after it are no longer logged.
        """
        self._requested = time.monotonic()
        if not self._number - len(self._kept) <= number <= self._number:
            raise incorrect_state(
                f"unknown event number {number}; the log has the last {len(self._kept)} events, "
                f"up to number {self._number}"
            )
        return wire.LoggedEvents(number=self._number, events=tuple(self.after(number)))

    def after(self, number: int) -> Iterator[wire.LoggedEvent]:
        """Return the events after a number, which must be logged."""
        return islice(self._kept, len(self._kept) - (self._number - number), None)
