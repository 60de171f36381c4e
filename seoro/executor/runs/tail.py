"""Tail of a trace: a request for records waits here, and is answered in parts as the trace grows.

Each part costs a message to each client, however small it is. So a busy executor sends larger parts.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

import anyio

SHARE: Final = 0.25  # of its time that an executor may send parts, before it delays them
CHECK_PERIOD: Final = 0.2  # [s] between two checks of the printed output
PERIOD: Final = 0.005  # [s] longest delay of a part

log = logging.getLogger(__name__)


class Watch:
    """A waiting request for records.

    Args:
        at: End of the trace that the client has received [bytes].
        room: Number of bytes that may be sent.
        send: Sends a part: its start, and whole lines.

    Attributes:
        over: Set when the run has changed otherwise, or no more bytes may be sent.
    """

    def __init__(self, at: int, room: int, send: Callable[[int, bytes], None]) -> None:
        self.at = at
        self.over = anyio.Event()
        self._room = room
        self._send = send

    def grow(self, start: int, lines: bytes) -> None:
        """Send new lines."""
        if self.over.is_set():
            return
        if start != self.at or len(lines) > self._room:
            self.over.set()
            return
        try:
            self._send(start, lines)
        except Exception:  # the client is disconnected
            log.info("cannot send a part", exc_info=True)
            self.over.set()
        else:
            self.at += len(lines)
            self._room -= len(lines)


class Pace:
    """Pace of parts of all runs; times are those of the event loop [s]."""

    def __init__(self) -> None:
        self._free = 0.0  # time from which a part may be sent at once

    def wait(self, now: float) -> float:
        """Return the delay of the next part [s]."""
        return min(max(self._free - now, 0.0), PERIOD)

    def note_duration(self, began: float, ended: float) -> None:
        """Record the time that a part took."""
        self._free = max(self._free, began) + (ended - began) / SHARE


async def until_printed(log: Path, at: int) -> None:
    """Wait until the printed output has more than `at` bytes."""
    while size_of(log) <= at:  # noqa: ASYNC110 - another process prints
        await anyio.sleep(CHECK_PERIOD)


def size_of(log: Path) -> int:
    """Return the size of the printed output [bytes]; 0 for a missing file."""
    try:
        return log.stat().st_size
    except FileNotFoundError:
        return 0


class Watches:
    """Waiting requests for the records of a run.

    Args:
        pace: Common pace of all runs of the executor.
    """

    def __init__(self, pace: Pace) -> None:
        self._pace = pace
        self._waiting: set[Watch] = set()
        self._start = 0  # start of the unsent lines
        self._unsent = bytearray()
        self._timer: asyncio.TimerHandle | None = None

    @contextmanager
    def added(self, watch: Watch) -> Iterator[None]:
        """Send new lines to a request while the block lasts."""
        self._send()  # lines that the new request has already
        self._waiting.add(watch)
        try:
            yield
        finally:
            self._waiting.discard(watch)

    def grow(self, start: int, lines: bytes) -> None:
        """Send new whole lines of the trace, now or delayed."""
        if not self._waiting:
            return
        if not self._unsent:
            self._start = start
        self._unsent += lines
        if self._timer is None:
            loop = asyncio.get_running_loop()
            wait = self._pace.wait(loop.time())
            if wait > 0.0:
                self._timer = loop.call_later(wait, self._send)
            else:
                self._send()

    def _send(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        if self._unsent:
            lines = bytes(self._unsent)
            self._unsent.clear()
            clock = asyncio.get_running_loop().time
            began = clock()
            for watch in tuple(self._waiting):
                watch.grow(self._start, lines)
            self._pace.note_duration(began, clock())

    def end_all(self) -> None:
        """End all requests, because the run has changed otherwise."""
        for watch in self._waiting:
            watch.over.set()
