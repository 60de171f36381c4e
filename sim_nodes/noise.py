"""Random numbers addressed by purpose and tick, independent of the order of draws.

With a shared generator, each number would depend on all draws before it, so that one more sensor would change the
run. Here each draw has its own generator: Philox (Salmon et al., SC 2011) is a function of a key and a counter.
The key is made of seed and purpose, the counter of the tick.
"""

from __future__ import annotations

from hashlib import blake2b

import numpy as np


class Noise:
    """The source of random numbers for one purpose.

    Args:
        seed: Seed of the simulation.
        purpose: Unique name, such as `turtlebot4/odometry`.
    """

    def __init__(self, seed: int, purpose: str) -> None:
        digest = blake2b(f"{seed}/{purpose}".encode(), digest_size=16).digest()
        self._key = np.frombuffer(digest, dtype=np.uint64)

    def at(self, tick: int) -> np.random.Generator:
        """Return the generator of a tick; every call returns the same numbers."""
        return np.random.Generator(np.random.Philox(key=self._key, counter=[0, 0, tick, 0]))
