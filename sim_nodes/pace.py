"""How fast time passes while a simulation plays: as the machine's clock, slower, faster, or as fast as it can."""

from __future__ import annotations

import math

SLICE = 0.02  # [s] simulated between two looks at the inbox, at rates up to 1
LONGEST_SLICE = 0.2  # [s] at higher ones: the looks would take a part of the time
FULL_SPEED_SLICES = (1 / 32, 1.0)  # [s] at least and at most, as fast as it can, by how long they take
LOOK = 0.01  # [s] of the machine's clock between two looks then, or half or twice of it
LAG = 0.5  # [s] of the machine's clock that playing may be behind; what is beyond is not made up for
ROUNDING = 1e-9  # of a slice
SLOWEST = 1e-3  # simulated seconds per second


class Pace:
    """The pace of a simulation that plays.

    Args:
        rate: Simulated seconds per second of the machine's clock; infinite for as fast as possible.
    """

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._slice = FULL_SPEED_SLICES[0] if math.isinf(rate) else min(SLICE * max(1.0, rate), LONGEST_SLICE)
        self._looked: float | None = None  # when the last slice at full speed began [s]
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
            return self._end_of_slice(clock, now)
        if self._anchor is None or (clock - self._anchor[0] - LAG) * self._rate > now - self._anchor[1]:
            self._anchor = (clock, now)
        return min(self._due(self._anchor, clock), now + self._slice)

    def _end_of_slice(self, clock: float, now: float) -> float:
        """The end of a slice at full speed, whose length is as long as is good for looking at the inbox.

        Slices end at multiples of their length, as what robots do has its times: none is cut in two for nothing.
        """
        if self._looked is not None:
            took, (least, most) = clock - self._looked, FULL_SPEED_SLICES
            if took < LOOK / 2.0:
                self._slice = min(2.0 * self._slice, most)
            elif took > 2.0 * LOOK:
                self._slice = max(self._slice / 2.0, least)
        self._looked = clock
        return (math.floor(now / self._slice + ROUNDING) + 1.0) * self._slice

    def wait(self, clock: float, now: float) -> float:
        """How long there is nothing to do [s], after what `until` said was simulated to `now`."""
        if self._anchor is None:
            return 0.0
        ahead = now - self._due(self._anchor, clock)
        return max(0.0, (ahead + self._slice) / self._rate) if ahead >= 0.0 else 0.0

    def _due(self, anchor: tuple[float, float], clock: float) -> float:
        return anchor[1] + (clock - anchor[0]) * self._rate
