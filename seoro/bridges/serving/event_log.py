"""Event log of a node, numbered and kept for clients that request it."""

from __future__ import annotations

import time
from collections import deque

import anyio

from seoro.bridges import wire
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused
from seoro.concurrency.condition import Condition

KEPT = 10_000  # last events; clients request them several times per second


class EventLog:
    """Log of the last events; for one event loop.

    Args:
        kept: Number of events to keep.
    """

    def __init__(self, kept: int = KEPT) -> None:
        self._kept: deque[wire.LoggedEvent] = deque(maxlen=kept)
        self.number = 0  # of the last event
        self._woken = 0
        self._began = time.monotonic()
        self._changes = Condition()

    @property
    def now(self) -> float:
        """Time since the start of the node [s]."""
        return time.monotonic() - self._began

    def add(
        self,
        *,
        occurrence: wire.Occurrence | None = None,
        contact: wire.Contact | None = None,
        feedback: wire.NavigationFeedback | None = None,
        warning: wire.GoalWarning | None = None,
    ) -> None:
        """Add an event, and wake waiting requests."""
        self.number += 1
        self._kept.append(
            wire.LoggedEvent(
                number=self.number, occurrence=occurrence, contact=contact, feedback=feedback, warning=warning
            )
        )
        self._changes.notify_all()

    def wake(self) -> None:
        """End the wait of all requests without an event."""
        self._woken += 1
        self._changes.notify_all()

    async def after(self, request: wire.AwaitEvents) -> wire.LoggedEvents:
        """Return all events after a number; waits for one, up to the time limit of the request.

        Raises:
            RequestRefused: The number is above the last one, or later events were dropped.
        """
        self._check(request.since)
        with anyio.move_on_after(min(max(request.wait, 0.0), wire.LONGEST_WAIT)):
            woken = self._woken
            await self._changes.wait_for(lambda: self.number > request.since or self._woken > woken)
        missing = self.number - request.since
        return wire.LoggedEvents(
            number=self.number, events=tuple(self._kept)[len(self._kept) - missing :] if missing else ()
        )

    def _check(self, since: int) -> None:
        if since > self.number:
            raise RequestRefused(
                Result.INCORRECT_STATE,
                f"unknown event {since}; the last event of this node is {self.number}: connect again",
            )
        if since < self.number - len(self._kept):
            raise RequestRefused(
                Result.INCORRECT_STATE,
                f"event {since} was dropped; only the last {len(self._kept)} events are kept: connect again",
            )
