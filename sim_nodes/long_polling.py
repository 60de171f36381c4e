"""Long polling: requests for events (`await_events`, `hold_robots`) that are answered when one occurs.

A node handles one request at a time. Requests without an event are deferred here, and the node continues.
"""

from __future__ import annotations

from dataclasses import dataclass

from seoro.bridges import wire
from seoro.bridges.session import Request
from sim_nodes.event_log import EventLog

MAX_WAITING = 64  # requests; further ones are answered at once


@dataclass(frozen=True)
class _Waiting:
    request: Request
    since: int
    until: float  # [s] of the monotonic clock


class LongPolls:
    """Requests that wait for an event.

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
