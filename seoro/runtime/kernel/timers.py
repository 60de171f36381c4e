"""`TimerQueue`: a priority queue of timers.

Contract: entries are taken at their times, in the order of their addition. A `Waiter` is woken, a `Timer` acts
before the first delta cycle of the instant, and a `Deadline` acts when the instant has otherwise settled. Entries
that are over are never taken.
"""

from __future__ import annotations

from collections.abc import Callable
from heapq import heapify, heappop, heappush
from itertools import count
from typing import TypeAlias

from seoro.runtime.kernel.clock import TIME_DIGITS
from seoro.runtime.kernel.task import Scope, Waiter

_SMALLEST_CLEARING = 1_000  # entries; smaller queues keep entries that are over


class Timer:
    """Function called at a time, before the first delta cycle of that instant, unless it is over before.

    Args:
        act: The function.
        over: Whether it is over.
        cause: Cause of its effects; see `CausalPast`.
    """

    __slots__ = ("act", "cause", "over")

    def __init__(self, act: Callable[[], None], over: bool = False, cause: int | None = None) -> None:
        self.act = act
        self.cause = cause
        self.over = over


class Deadline:
    """Function on a scope, called when an instant has otherwise settled, unless it is over before.

    Args:
        scope: The limited scope.
        act: The function; called at commit. Its cause is that of the present state of the scope.
    """

    __slots__ = ("act", "cause", "over", "scope")

    def __init__(self, scope: Scope, act: Callable[[], None]) -> None:
        self.scope = scope
        self.cause = scope.task.past.cause
        self.act = act
        self.over = False


Entry: TypeAlias = Waiter | Timer | Deadline


class TimerQueue:
    """Entries ordered by time.

    Entries that are over are dropped at their time, or when they are the majority: a loop within a long timeout
    leaves one behind in each iteration.
    """

    def __init__(self) -> None:
        self._entries: list[tuple[float, int, Entry]] = []
        self._numbers = count()
        self._clear_at = _SMALLEST_CLEARING

    def __len__(self) -> int:
        """Return the number of entries that are not over."""
        return sum(not entry.over for _, _, entry in self._entries)

    def add(self, time: float, entry: Entry) -> None:
        """Add an entry that is due at a time [s]."""
        if len(self._entries) >= self._clear_at:
            self._entries = [each for each in self._entries if not each[2].over]
            heapify(self._entries)
            self._clear_at = max(2 * len(self._entries), _SMALLEST_CLEARING)
        heappush(self._entries, (round(time, TIME_DIGITS), next(self._numbers), entry))

    @property
    def next_due(self) -> float | None:
        """Time of the next entry [s]; None if empty."""
        entries = self._entries
        while entries and entries[0][2].over:
            heappop(entries)
        return entries[0][0] if entries else None

    def take(self, now: float) -> Entry | None:
        """Remove and return the next due entry, or None."""
        entries = self._entries
        while entries and entries[0][0] <= now:
            entry = heappop(entries)[2]
            if not entry.over:
                return entry
        return None
