"""How fast time passes while a simulation plays: as the machine's clock, slower, faster, or as fast as it can."""

from __future__ import annotations

import math

SLICE = 0.02  # [s] simulated between two looks at the inbox, at rates up to 1
LONGEST_SLICE = 0.2  # [s] at higher ones: the looks would take a part of the time
LAG = 0.5  # [s] of the machine's clock that playing may be behind; what is beyond is not made up for
SLOWEST = 1e-3  # simulated seconds per second


class Pace:
    """The pace of a simulation that plays.

    Args:
        rate: Simulated seconds per second of the machine's clock; infinite for as fast as possible.
    """

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._slice = min(SLICE * max(1.0, rate), LONGEST_SLICE)
        self._anchor: tuple[float, float] | None = None

    def start_over(self) -> None:
        """Count from the present: the simulation's clock has been set."""
        self._anchor = None

    def until(self, clock: float, now: float) -> float:
        """The time to simulate to now, which is not after the present if that is ahead [s].

        Args:
            clock: The machine's monotonic clock [s].
            now: The simulation's clock [s].
        """
        if math.isinf(self._rate):
            return now + self._slice
        if self._anchor is None or (clock - self._anchor[0] - LAG) * self._rate > now - self._anchor[1]:
            self._anchor = (clock, now)
        return min(self._due(self._anchor, clock), now + self._slice)

    def wait(self, clock: float, now: float) -> float:
        """How long there is nothing to do [s], after what `until` said was simulated to `now`."""
        if self._anchor is None:
            return 0.0
        ahead = now - self._due(self._anchor, clock)
        return max(0.0, (ahead + self._slice) / self._rate) if ahead >= 0.0 else 0.0

    def _due(self, anchor: tuple[float, float], clock: float) -> float:
        return anchor[1] + (clock - anchor[0]) * self._rate
