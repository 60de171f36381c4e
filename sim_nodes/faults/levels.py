"""What becomes of brightness that is off and noisy, is rounded to a level, and is cut off at both ends."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from sim_nodes.geometry import Array
from sim_nodes.sensors.pixels import BRIGHTEST

LEVELS = np.arange(BRIGHTEST + 1)

Counts = NDArray[np.intp]


@dataclass(frozen=True)
class Expected:
    """Sums over many errors: what they are expected to be, and their variance."""

    mean: float
    variance: float


class Levels:
    """The levels that become of each level.

    Args:
        deviation: Standard deviation of the errors before rounding [levels].
        offset: What values are off by [levels].
    """

    def __init__(self, deviation: float, offset: float) -> None:
        self._probabilities = _probabilities(deviation, offset)  # by the level that it was, and the one that it is

    def expected(self, counts: Counts, centre: float, power: int) -> Expected:
        """The sum of a power of the errors about a value.

        Args:
            counts: How many values there are of each level, shape (256,).
            centre: The value [levels].
            power: The power.
        """
        errors = (LEVELS[None, :] - LEVELS[:, None] - centre) ** power
        means = (self._probabilities * errors).sum(axis=1)
        variances = (self._probabilities * errors**2).sum(axis=1) - means**2
        return Expected(float(counts @ means), max(0.0, float(counts @ variances)))


@lru_cache(maxsize=16)
def _probabilities(deviation: float, offset: float) -> Array:
    from scipy.special import ndtr  # noqa: PLC0415 - slow to load, and seldom needed

    middle = LEVELS + offset
    if deviation == 0.0:
        certain: Array = (np.clip(np.rint(middle), 0, BRIGHTEST)[:, None] == LEVELS).astype(np.float64)
        return certain
    borders = np.concatenate(([-np.inf], LEVELS[1:] - 0.5, [np.inf]))
    probabilities: Array = np.diff(ndtr((borders[None, :] - middle[:, None]) / deviation), axis=1)
    return probabilities
