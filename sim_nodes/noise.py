"""Random numbers by what they are for and when, not by who asked before.

A generator that everybody draws from makes each number depend on all draws before it, so that one more listener
changes the run. Here each draw has its own generator: Philox (Salmon et al., SC 2011) is a function of a key
and a counter, the key is made of the seed and the purpose, the counter of the tick.
"""

from __future__ import annotations

from hashlib import blake2b

import numpy as np


class Noise:
    """The source of random numbers of one purpose.

    Args:
        seed: Seed of the simulation.
        purpose: What the numbers are for, such as `turtlebot4/odometry`.
    """

    def __init__(self, seed: int, purpose: str) -> None:
        digest = blake2b(f"{seed}/{purpose}".encode(), digest_size=16).digest()
        self._key = np.frombuffer(digest, dtype=np.uint64)

    def at(self, tick: int) -> np.random.Generator:
        """The generator of a tick; asked twice it gives the same numbers twice."""
        return np.random.Generator(np.random.Philox(key=self._key, counter=[0, 0, tick, 0]))
