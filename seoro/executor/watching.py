"""Those who follow runs get what comes at once: a request for records waits here, and is answered in parts.

A part costs each of those who follow a message, however little is in it. So an executor that has much to send
sends it in larger parts.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

import anyio

SHARE: Final = 0.25  # of its time that an executor sends parts, before they become larger
LOOK: Final = 0.2  # [s] between two looks at what a run prints, which nobody tells
PERIOD: Final = 0.005  # [s] from one part of a run to the next, at most, when they do

log = logging.getLogger(__name__)


class Watch:
    """A request that waits.

    Args:
        at: Up to which byte its sender has the trace.
        room: How many bytes it may be sent.
        send: Sends a part: where it begins, and whole lines.

    `over` is set when there is something that is no part of a trace to tell, or there is no more room.
    """

    def __init__(self, at: int, room: int, send: Callable[[int, bytes], None]) -> None:
        self.at = at
        self.over = anyio.Event()
        self._room = room
        self._send = send

    def grow(self, start: int, lines: bytes) -> None:
        """The trace has grown."""
        if self.over.is_set():
            return
        if start != self.at or len(lines) > self._room:
            self.over.set()
            return
        try:
            self._send(start, lines)
        except Exception:  # whoever asked is gone
            log.info("cannot send a part", exc_info=True)
            self.over.set()
        else:
            self.at += len(lines)
            self._room -= len(lines)


class Pace:
    """When parts of all runs are sent; times are those of the event loop [s]."""

    def __init__(self) -> None:
        self._free = 0.0  # from when on no more than the share was taken for what was sent

    def wait(self, now: float) -> float:
        """How long a part has to wait."""
        return min(max(self._free - now, 0.0), PERIOD)

    def took(self, began: float, ended: float) -> None:
        """A part was sent."""
        self._free = max(self._free, began) + (ended - began) / SHARE


async def until_printed(log: Path, at: int) -> None:
    """Wait until a file for what is printed has more than some bytes."""
    while size_of(log) <= at:  # noqa: ASYNC110 - it is another process that prints
        await anyio.sleep(LOOK)


def size_of(log: Path) -> int:
    """Of a file for what is printed, which may not be there [bytes]."""
    try:
        return log.stat().st_size
    except FileNotFoundError:
        return 0


class Watches:
    """The requests that wait for what comes of a run.

    Args:
        pace: Of all runs of the executor.
    """

    def __init__(self, pace: Pace) -> None:
        self._pace = pace
        self._waiting: set[Watch] = set()
        self._start = 0  # where what was not sent yet begins
        self._unsent = bytearray()
        self._timer: asyncio.TimerHandle | None = None

    @contextmanager
    def having(self, watch: Watch) -> Iterator[None]:
        """Tell a request for as long as the block lasts."""
        self._send()  # which the new one has already
        self._waiting.add(watch)
        try:
            yield
        finally:
            self._waiting.discard(watch)

    def grow(self, start: int, lines: bytes) -> None:
        """The trace has grown by whole lines."""
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
            self._pace.took(began, clock())

    def turn(self) -> None:
        """Something else about the run has changed."""
        for watch in self._waiting:
            watch.over.set()
