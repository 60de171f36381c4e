"""State that a bridge shares with its guard: standstills, unanswered goals and pending emergency stops."""

from __future__ import annotations

import threading
import time
from collections import Counter
from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from typing import Final

from seoro.bridges.serving.work import GoalInterrupted

SILENCE: Final = 0.3  # [s] without a heartbeat, after which a bridge stands still
STOOD_STILL: Final = "the bridge stood still"


class Standstills:
    """Counter of standstills of this process: times without a heartbeat, after which the guard stops the robots.

    Commands from before a standstill must not move a robot afterwards. So each command keeps the number of
    standstills at its start, and holds while that number is unchanged.

    Attributes:
        on_standstill: Called from any thread after each standstill.
    """

    def __init__(self) -> None:
        self._number = 0
        self._last: float | None = None  # last heartbeat, by the machine's clock [s]; None without a guard
        self._lock = threading.Lock()
        self.on_standstill: Callable[[], object] = lambda: None

    @property
    def number(self) -> int:
        """Number of standstills, including one that has just ended."""
        with self._lock:
            if self._last is not None:
                self._update(time.monotonic())
            return self._number

    def _update(self, now: float) -> None:
        if self._last is not None and now - self._last > SILENCE:
            self._number += 1
            self._last = now
            self.on_standstill()

    def note_heartbeat(self) -> None:
        """Note that a heartbeat is sent now."""
        with self._lock:
            now = time.monotonic()
            self._update(now)
            self._last = now

    def note_end(self) -> None:
        """Note that heartbeats have ended with the guard."""
        with self._lock:
            self._last = None

    def check(self, since: int) -> None:
        """Check that the number of standstills is unchanged.

        Raises:
            GoalInterrupted: The bridge stood still.
        """
        if self.number != since:
            raise GoalInterrupted(STOOD_STILL)


@dataclass
class GuardState:
    """State that a bridge shares with its guard; emergency stops may come from any thread.

    Attributes:
        standstills: Standstills of the bridge.
        on_change: Called when the first goal becomes unanswered, when none is any more, and with each change of
            the emergency stops.
    """

    standstills: Standstills = field(default_factory=Standstills)
    on_change: Callable[[], None] = lambda: None
    _unanswered: int = 0
    _stops: Counter[str] = field(default_factory=Counter)  # pending emergency stops by robot
    _lock: threading.Lock = field(default_factory=threading.Lock)

    @property
    def has_unanswered(self) -> bool:
        """Whether a sent goal is unanswered, and may be accepted after the end of the bridge."""
        return self._unanswered > 0

    def add_unanswered(self) -> None:
        """Add a goal, before it is sent."""
        self._unanswered += 1
        if self._unanswered == 1:
            self.on_change()

    def remove_unanswered(self) -> None:
        """Remove a goal that was answered, or is not waited for any more."""
        self._unanswered -= 1
        if self._unanswered == 0:
            self.on_change()

    @property
    def stopping(self) -> frozenset[str]:
        """Names of the robots with a pending emergency stop."""
        with self._lock:
            return frozenset(+self._stops)

    def set_stopping(self, robots: Collection[str], is_on: bool) -> None:
        """Set whether robots have a pending emergency stop, which the bridge has not carried out yet."""
        with self._lock:
            if is_on:
                self._stops.update(robots)
            else:
                self._stops.subtract(robots)
        self.on_change()
