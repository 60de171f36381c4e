"""Physics steps in batches that end soon by the machine's clock, however large the world is.

A call of an engine cannot be interrupted. Between two, the main thread sees an emergency stop, and in engines that
keep other threads from running, the thread that hears of it gets its turn. How many steps are made at once changes
nothing: states are the same, bit for bit (`Engine.step`).
"""

from __future__ import annotations

import time
from collections.abc import Callable
from threading import Event
from typing import Final

from sim_nodes.physics import Engine

LONGEST: Final = 0.05  # [s] of the machine's clock that a batch should take at most
GROWTH: Final = 4  # times as many steps in the next batch, at most
MOST: Final = 1000  # steps


class Batches:
    """Makes the steps of an engine in batches.

    Args:
        clock: The machine's monotonic clock [s].
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._size = 1

    def make(self, engine: Engine, count: int, halted: Event) -> int:
        """Make up to `count` steps, at least one, to the first after which other pairs of entities touch.

        Args:
            engine: The engine.
            count: How many.
            halted: Ends them, too, after a batch.

        Returns:
            How many were made.

        Raises:
            UnstablePhysics: The engine could not, and the world is lost.
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

    def _fit(self, made: int, took: float) -> None:
        """Fit the size of the next batch to the time that steps take [s]."""
        allowed = int(LONGEST * made / took) if took > 0.0 else MOST
        self._size = max(1, min(allowed, GROWTH * self._size, MOST))
