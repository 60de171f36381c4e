"""Events of a simulation, logged for clients that follow them; see `seoro.bridges.wire.event_log`."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Iterator, Mapping
from itertools import islice

from seoro.bridges import wire
from seoro.bridges.session import Request
from seoro.deferred import dataclass
from sim_nodes.outcomes import incorrect_state
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


class EventLog:
    """Events of a simulator across its worlds, numbered from 1.

    Attributes:
        worlds: Number of worlds so far; being without one counts as a world.
        number: Number of the last event.
    """

    def __init__(self) -> None:
        self.worlds = 0
        self._world: World | None = None
        self._kept: deque[wire.LoggedEvent] = deque(maxlen=KEPT)
        self.number = 0
        self._requested: float | None = None

    @property
    def is_followed(self) -> bool:
        """Whether a client repeatedly requests events."""
        return self._requested is not None and time.monotonic() - self._requested < FOLLOW_TIMEOUT

    def add(self, event: WorldEvent | wire.WorldChange) -> None:
        """Log an event."""
        self.number += 1
        self._kept.append(wire.LoggedEvent.model_validate({"number": self.number, FIELDS[type(event)]: event}))

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
        self.number = number

    def since(self, number: int) -> wire.LoggedEvents:
        """Return the events after a number.

        Raises:
            RequestRefused: The number is in the future, or later events were dropped from the log.
        """
        self._requested = time.monotonic()
        if not self.number - len(self._kept) <= number <= self.number:
            raise incorrect_state(
                f"unknown event number {number}; the log has the last {len(self._kept)} events, "
                f"up to number {self.number}"
            )
        return wire.LoggedEvents(number=self.number, events=tuple(self.after(number)))

    def after(self, number: int) -> Iterator[wire.LoggedEvent]:
        """Return the events after a number, which must be logged."""
        return islice(self._kept, len(self._kept) - (self.number - number), None)


MAX_WAITING = 64  # requests; further ones are answered at once


@dataclass(frozen=True)
class _Waiting:
    request: Request
    since: int
    until: float  # [s] of the monotonic clock


class LongPolls:
    """Requests for events (`await_events`, `hold_robots`) that are answered when one occurs.

    A node handles one request at a time. Requests without an event are deferred here, and the node continues.

    Args:
        log: Log of events.
    """

    def __init__(self, log: EventLog) -> None:
        self._log = log
        self._waiting: list[_Waiting] = []

    def defer(self, request: Request, clock: float) -> bool:
        """Defer a request if it has to wait; returns False if it is to be answered now.

        Args:
            request: The request.
            clock: Monotonic clock [s].
        """
        if len(self._waiting) >= MAX_WAITING:
            return False
        try:
            asked = wire.AWAIT_EVENTS.read(request.payload)
        except wire.WireError:
            return False
        if asked.since != self._log.number or not 0.0 < asked.wait <= wire.LONGEST_WAIT:
            return False
        self._log.since(asked.since)  # marks the log as followed
        self._waiting.append(_Waiting(request, asked.since, clock + asked.wait))
        return True

    def pop_due(self, clock: float) -> list[Request]:
        """Remove and return the requests with a new event or an expired wait, at a monotonic clock [s]."""
        due = [each for each in self._waiting if each.since != self._log.number or each.until <= clock]
        if due:
            self._waiting = [each for each in self._waiting if each not in due]
        return [each.request for each in due]

    def pop_all(self) -> list[Request]:
        """Remove and return all requests, to answer them now."""
        waiting, self._waiting = self._waiting, []
        return [each.request for each in waiting]

    def time_to_next(self, clock: float) -> float | None:
        """Return the time until the next wait expires [s]; None without requests."""
        if not self._waiting:
            return None
        return max(0.0, min(each.until for each in self._waiting) - clock)
