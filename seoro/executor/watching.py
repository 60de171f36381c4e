"""Those who follow runs get what comes at once: a request for records waits here, and is answered in parts."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import anyio

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


class Watches:
    """The requests that wait for what comes of a run."""

    def __init__(self) -> None:
        self._waiting: set[Watch] = set()

    @contextmanager
    def having(self, watch: Watch) -> Iterator[None]:
        """Tell a request for as long as the block lasts."""
        self._waiting.add(watch)
        try:
            yield
        finally:
            self._waiting.discard(watch)

    def grow(self, start: int, lines: bytes) -> None:
        """The trace has grown by whole lines."""
        for watch in tuple(self._waiting):
            watch.grow(start, lines)

    def turn(self) -> None:
        """Something else about the run has changed."""
        for watch in self._waiting:
            watch.over.set()
