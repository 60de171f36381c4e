"""What has happened at a node, numbered and kept for clients that ask for it."""

from __future__ import annotations

import time
from collections import deque

import anyio

from seoro.bridges import wire
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused
from seoro.changes import Changes

KEPT = 10_000  # the last of them; a client asks several times a second


class HappeningLog:
    """The last things that happened; for one event loop.

    Args:
        kept: How many of them.
    """

    def __init__(self, kept: int = KEPT) -> None:
        self._kept: deque[wire.Happening] = deque(maxlen=kept)
        self._number = 0
        self._woken = 0
        self._began = time.monotonic()
        self._changes = Changes()

    @property
    def number(self) -> int:
        """Of the last thing that happened; 0 when nothing has."""
        return self._number

    @property
    def now(self) -> float:
        """The time of the node [s], since it was started."""
        return time.monotonic() - self._began

    def tell(
        self,
        *,
        occurrence: wire.Occurrence | None = None,
        contact: wire.Contact | None = None,
        feedback: wire.NavigationFeedback | None = None,
        caution: wire.Caution | None = None,
    ) -> None:
        """Note that something has happened, and wake whoever waits for it."""
        self._number += 1
        self._kept.append(
            wire.Happening(
                number=self._number, occurrence=occurrence, contact=contact, feedback=feedback, caution=caution
            )
        )
        self._changes.tell()

    def wake(self) -> None:
        """Answer those who wait, though nothing has happened."""
        self._woken += 1
        self._changes.tell()

    async def after(self, request: wire.AwaitHappenings) -> wire.Happenings:
        """Everything after a number; waits for something, as long as the request says.

        Raises:
            RequestRefused: The number is not one of this log's, or what came after it is not kept any more.
        """
        self._check(request.since)
        with anyio.move_on_after(min(max(request.wait, 0.0), wire.LONGEST_WAIT)):
            woken = self._woken
            await self._changes.wait_for(lambda: self._number > request.since or self._woken > woken)
        missing = self._number - request.since
        return wire.Happenings(
            number=self._number, happenings=tuple(self._kept)[len(self._kept) - missing :] if missing else ()
        )

    def _check(self, since: int) -> None:
        if since > self._number:
            raise RequestRefused(
                Result.INCORRECT_STATE,
                f"{self._number} things have happened since this node was started, not {since}: connect again",
            )
        if since < self._number - len(self._kept):
            raise RequestRefused(
                Result.INCORRECT_STATE,
                f"only the last {len(self._kept)} things that happened are kept: connect again",
            )
