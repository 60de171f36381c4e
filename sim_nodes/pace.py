"""Pace of a simulation: relative to the wall clock while it plays, and by batches of physics steps.

Calls of an engine cannot be interrupted. Between two calls, the main thread checks for emergency stops; engines
that hold the GIL also let other threads run only then. Batch sizes do not affect results: the states are
bit-identical (`Engine.step`).
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from threading import Event
from typing import Final

from sim_nodes.physics import Engine

SLICE = 0.02  # [s] simulated between two checks of the inbox, at rates up to 1
LONGEST_SLICE = 0.2  # [s] at higher rates, where frequent checks would cost time
FULL_SPEED_SLICES = (1 / 32, 1.0)  # [s] minimum and maximum at full speed, adapted to the wall time they take
LOOK = 0.01  # [s] target wall time between two checks at full speed, within a factor of 2
LAG = 0.5  # [s] wall time that playing may lag behind; more lag is dropped
ROUNDING = 1e-9  # of a slice
SLOWEST = 1e-3  # simulated seconds per second


class Pace:
    """The pace of a playing simulation.

    Args:
        rate: Simulated seconds per second of wall time; infinite for as fast as possible.
    """

    def __init__(self, rate: float) -> None:
        self._rate = rate
        self._slice = FULL_SPEED_SLICES[0] if math.isinf(rate) else min(SLICE * max(1.0, rate), LONGEST_SLICE)
        self._looked: float | None = None  # start of the last slice at full speed [s]
        self._anchor: tuple[float, float] | None = None

    def start_over(self) -> None:
        """Restart from the present, after a change of the simulation time."""
        self._anchor = None

    def until(self, clock: float, now: float) -> float:
        """Return the time to simulate to [s]; not after `now` if the simulation is ahead.

        Args:
            clock: Monotonic clock [s].
            now: Simulation time [s].
        """
        if math.isinf(self._rate):
            return self._end_of_slice(clock, now)
        if self._anchor is None or (clock - self._anchor[0] - LAG) * self._rate > now - self._anchor[1]:
            self._anchor = (clock, now)
        return min(self._due(self._anchor, clock), now + self._slice)

    def _end_of_slice(self, clock: float, now: float) -> float:
        """Return the end of a slice at full speed; its length adapts to the wall time between checks of the inbox.

        Slices end at multiples of their length, which coincide with the periods of robots.
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
        """Return the idle time [s] after the simulation has reached the result of `until`."""
        if self._anchor is None:
            return 0.0
        ahead = now - self._due(self._anchor, clock)
        return max(0.0, (ahead + self._slice) / self._rate) if ahead >= 0.0 else 0.0

    def _due(self, anchor: tuple[float, float], clock: float) -> float:
        return anchor[1] + (clock - anchor[0]) * self._rate


TARGET: Final = 0.05  # [s] target wall time of a batch
GROWTH: Final = 4  # maximum factor between the sizes of two batches
MOST: Final = 1000  # maximum steps of a batch


class Batches:
    """Makes physics steps in batches.

    Args:
        clock: Monotonic clock [s].
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._size = 1

    def make(self, engine: Engine, count: int, halted: Event) -> int:
        """Make up to `count` steps, at least one; stop after a step in which the pairs in contact change.

        Args:
            engine: The engine.
            count: Maximum number of steps.
            halted: Event that stops after the present batch.

        Returns:
            Number of steps made.

        Raises:
            UnstablePhysics: The physics has diverged.
        """
        made, touching = 0, engine.touching()
        while True:
            wanted = min(count - made, self._size)
            began = self._clock()
            some = engine.step(wanted)
            self._fit(some, self._clock() - began)
            made += some
            if made >= count or some < wanted or halted.is_set() or engine.touching() != touching:
                return made

    def _fit(self, made: int, duration: float) -> None:
        """Adapt the size of the next batch to the wall time of the last one [s]."""
        allowed = int(TARGET * made / duration) if duration > 0.0 else MOST
        self._size = max(1, min(allowed, GROWTH * self._size, MOST))
