"""Random numbers addressed by purpose and tick, independent of the order of draws.

With a shared generator, each number would depend on all draws before it, so that one more sensor would change the
run. Here each draw has its own generator: Philox (Salmon et al., SC 2011) is a function of a key and a counter.
The key is made of seed and purpose, the counter of the tick.
"""

from __future__ import annotations

from hashlib import blake2b
from typing import Any

import numpy as np

from sim_nodes.stateful import Stateful

NOTHING = np.zeros(4, dtype=np.uint64)  # numbers in the buffer of a new generator, all of them used


class Noise(Stateful):
    """The source of random numbers for one purpose.

    Args:
        seed: Seed of the simulation.
        purpose: Unique name, such as `turtlebot4/odometry`.
    """

    DERIVED = ("_counter", "_start")  # of the last draw

    def __init__(self, seed: int, purpose: str) -> None:
        digest = blake2b(f"{seed}/{purpose}".encode(), digest_size=16).digest()
        self._key = np.frombuffer(digest, dtype=np.uint64)
        # One generator for all ticks: to make another takes five times as long as to set its state.
        self._philox = np.random.Philox(key=self._key)
        self._generator = np.random.Generator(self._philox)
        self._counter = np.zeros(4, dtype=np.uint64)
        self._start: Any = {  # copied by the generator
            "bit_generator": "Philox",
            "state": {"counter": self._counter, "key": self._key},
            "buffer": NOTHING,
            "buffer_pos": len(NOTHING),
            "has_uint32": 0,
            "uinteger": 0,
        }

    def at(self, tick: int) -> np.random.Generator:
        """Return the generator of a tick, valid until the next call; every call returns the same numbers."""
        self._counter[2] = tick
        self._philox.state = self._start
        return self._generator
