"""What is due when: waiters that are fired, timers that act, and limits that act when all else has."""

from __future__ import annotations

import heapq
from collections.abc import Callable
from itertools import count
from typing import TypeAlias

from seoro.runtime.flows import Scope, Waiter

TIME_DIGITS = 9  # times are kept to the nanosecond, so that 0.1 + 0.2 is due with 0.3
_SMALLEST_CLEARING = 1_000  # entries; below, those that are over may stay


class Timer:
    """What happens at a time, before the first round of that instant, unless it is over before.

    Args:
        act: Called then.
        over: Whether it is over.
    """

    __slots__ = ("act", "over")

    def __init__(self, act: Callable[[], None], over: bool = False) -> None:
        self.act = act
        self.over = over


class Limit:
    """What a scope comes to in an instant, unless it is over before; it acts when that has otherwise settled.

    Args:
        scope: Of what it limits.
        act: Called between rounds.
    """

    __slots__ = ("act", "over", "scope")

    def __init__(self, scope: Scope, act: Callable[[], None]) -> None:
        self.scope = scope
        self.act = act
        self.over = False


Entry: TypeAlias = Waiter | Timer | Limit


class Timetable:
    """Entries by their times; those of one time come in the order in which they were added.

    Entries that are over are dropped at their time, or when they are the larger part: a loop within a long timeout
    leaves one behind each time.
    """

    def __init__(self) -> None:
        self._entries: list[tuple[float, int, Entry]] = []
        self._numbers = count()
        self._clear_at = _SMALLEST_CLEARING

    def add(self, time: float, entry: Entry) -> None:
        """Add an entry that is due at a time [s]."""
        if len(self._entries) >= self._clear_at:
            self._entries = [each for each in self._entries if not each[2].over]
            heapq.heapify(self._entries)
            self._clear_at = max(2 * len(self._entries), _SMALLEST_CLEARING)
        heapq.heappush(self._entries, (round(time, TIME_DIGITS), next(self._numbers), entry))

    @property
    def next_due(self) -> float | None:
        """When the next entry is due [s]; None if there is none."""
        entries = self._entries
        while entries and entries[0][2].over:
            heapq.heappop(entries)
        return entries[0][0] if entries else None

    def take(self, now: float) -> Entry | None:
        """The next entry that is due by now, which is no longer in the table; None if there is none."""
        entries = self._entries
        while entries and entries[0][0] <= now:
            entry = heapq.heappop(entries)[2]
            if not entry.over:
                return entry
        return None
