"""Requests for what happens (`await_happenings`, `hold_robots`), which are answered when something has happened.

A node carries out one request at a time. Those that find nothing are put aside here, and the node goes on.
"""

from __future__ import annotations

from dataclasses import dataclass

from seoro.bridges.session import Request
from seoro.bridges.wire import (
    AWAIT_HAPPENINGS,
    HOLD_ROBOTS,
    LONGEST_WAIT,
    WireError,
)
from seoro.bridges.wire.keys import verb_of
from sim_nodes.happenings import Log

MAX_WAITING = 64  # requests; more are answered at once
VERBS = frozenset({AWAIT_HAPPENINGS.name, HOLD_ROBOTS.name})


@dataclass(frozen=True)
class _Waiting:
    request: Request
    since: int
    until: float  # [s] of the machine's monotonic clock


class WaitingRequests:
    """Requests that wait for something to happen.

    Args:
        log: What happens.
    """

    def __init__(self, log: Log) -> None:
        self._log = log
        self._waiting: list[_Waiting] = []

    def put_aside(self, request: Request, clock: float) -> bool:
        """Let a request wait, if it is one that has to; False for all others, which are to be answered now.

        Args:
            request: The request.
            clock: The machine's monotonic clock [s].
        """
        if verb_of(request.key) not in VERBS or len(self._waiting) >= MAX_WAITING:
            return False
        try:
            asked = AWAIT_HAPPENINGS.read(request.payload)
        except WireError:
            return False
        if asked.since != self._log.number or not 0.0 < asked.wait <= LONGEST_WAIT:
            return False
        self._log.since(asked.since)  # somebody follows
        self._waiting.append(_Waiting(request, asked.since, clock + asked.wait))
        return True

    def due(self, clock: float) -> list[Request]:
        """Those for whom something has happened, or whose time is over by the machine's clock [s]."""
        due = [each for each in self._waiting if each.since != self._log.number or each.until <= clock]
        if due:
            self._waiting = [each for each in self._waiting if each not in due]
        return [each.request for each in due]

    def all(self) -> list[Request]:
        """All of them, which are to be answered now."""
        waiting, self._waiting = self._waiting, []
        return [each.request for each in waiting]

    def within(self, clock: float) -> float | None:
        """How long there is nothing to do here if nothing happens [s]; None if nobody waits."""
        if not self._waiting:
            return None
        return max(0.0, min(each.until for each in self._waiting) - clock)
