"""Standstills of the bridge: times in which it gave no sign of life, so that its guard has stopped its robots.

What was going on before must not move a robot again when the bridge goes on. So each command keeps how
many standstills there were when it was given, and holds no longer than there are as many.
"""

from __future__ import annotations

import threading
import time
from typing import Final

from seoro.bridges.serving.work import Interrupted

SILENCE: Final = 0.3  # [s] without a sign of life, after which a bridge stands still
STOOD_STILL: Final = "the bridge stood still"


class Standstills:
    """Counts the standstills of this process; told of by the thread that gives signs of life, asked by others."""

    def __init__(self) -> None:
        self._number = 0
        self._last: float | None = None  # sign of life, by the machine's clock [s]; None while there is no guard
        self._lock = threading.Lock()

    @property
    def number(self) -> int:
        """How many there were, with one that has just ended."""
        with self._lock:
            if self._last is not None and time.monotonic() - self._last > SILENCE:
                self._number += 1
                self._last = time.monotonic()
            return self._number

    def note_sign(self) -> None:
        """A sign of life is given now."""
        with self._lock:
            now = time.monotonic()
            if self._last is not None and now - self._last > SILENCE:
                self._number += 1
            self._last = now

    def note_end(self) -> None:
        """No signs of life are given any more, as there is no guard."""
        with self._lock:
            self._last = None

    def check(self, since: int) -> None:
        """Check that there was none since there were so many.

        Raises:
            Interrupted: There was one.
        """
        if self.number != since:
            raise Interrupted(STOOD_STILL)
