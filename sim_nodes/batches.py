"""Physics steps in batches that take a short wall time in worlds of any size.

Calls of an engine cannot be interrupted. Between two calls, the main thread checks for emergency stops; engines
that hold the GIL also let other threads run only then. Batch sizes do not affect results: the states are
bit-identical (`Engine.step`).
"""

from __future__ import annotations

import time
from collections.abc import Callable
from threading import Event
from typing import Final

from sim_nodes.physics import Engine

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
