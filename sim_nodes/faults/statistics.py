"""Statistics of checks: measured sums, and the moments that they should have under errors, limits and rounding."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from seoro.deferred import dataclass
from sim_nodes.geometry import Array
from sim_nodes.sensors.sensor_pipeline import BRIGHTEST
from sim_nodes.stateful import Stateful

ROUNDING = 1e-9
LEVELS = np.arange(BRIGHTEST + 1)
FAR = 40.0  # standard deviations that count as infinitely many

Counts = NDArray[np.intp]


@dataclass(frozen=True)
class Criterion:
    """Accuracy that a tally must reach.

    Args:
        deviations: Tolerance in standard deviations.
        precision: Maximum tolerance as a share of the effect of the fault.
        least: Minimum number of values.
    """

    deviations: float
    precision: float
    least: int


VALUES = Criterion(deviations=4.0, precision=0.5, least=20)
MESSAGES = Criterion(deviations=3.0, precision=1.0, least=10)  # few samples


class Tally(Stateful):
    """A measured sum, its expectations with and without the fault, and its variance."""

    STATE = ("count", "found", "expected", "sound", "_variance")

    def __init__(self, criterion: Criterion) -> None:
        self._criterion = criterion
        self._variance = 0.0
        self.count = 0
        self.found = 0.0
        self.expected = 0.0
        self.sound = 0.0  # expected without the fault

    def add(self, count: int, found: float, expected: float, sound: float, variance: float) -> None:
        """Add values."""
        self.count += count
        self.found += found
        self.expected += expected
        self.sound += sound
        self._variance += variance

    @property
    def fits(self) -> bool:
        """Whether the sum fits the fault."""
        return abs(self.found - self.expected) <= self._tolerance

    @property
    def is_confirmed(self) -> bool:
        """Whether the sum fits the fault, and does not fit half of its effect."""
        effect = abs(self.expected - self.sound)
        return (
            self.fits
            and self.count >= self._criterion.least
            and self._tolerance <= self._criterion.precision * effect
        )

    @property
    def _tolerance(self) -> float:
        return self._criterion.deviations * math.sqrt(self._variance) + ROUNDING * (1.0 + abs(self.expected))


@dataclass(frozen=True)
class Truncated:
    """Moments of truncated normal distributions, about the mean before truncation.

    Standard formulas, in standard deviations; arrays of shape (n,).
    """

    share: Array  # remaining share
    first: Array  # mean
    second: Array  # mean of the squares
    fourth: Array


def truncated(low: Array, high: Array) -> Truncated:
    """Return the moments of standard normal distributions within `low` and `high`."""
    from scipy.special import ndtr  # noqa: PLC0415 - slow to load, and seldom needed

    a, b = np.clip(low, -FAR, FAR), np.clip(high, -FAR, FAR)
    share = ndtr(b) - ndtr(a)
    at_a, at_b = _density(a), _density(b)
    with np.errstate(divide="ignore", invalid="ignore"):  # unused where nothing remains
        return Truncated(
            share,
            (at_a - at_b) / share,
            1.0 + (a * at_a - b * at_b) / share,
            3.0 + ((a**3 + 3.0 * a) * at_a - (b**3 + 3.0 * b) * at_b) / share,
        )


def _density(x: Array) -> Array:
    density: Array = np.exp(-0.5 * x * x) / np.sqrt(2.0 * np.pi)
    return density


@dataclass(frozen=True)
class Levels:
    """Distribution of the levels of brightness that result from each true level, by errors, rounding and clipping.

    Args:
        deviation: Standard deviation of the errors before rounding [levels].
        offset: Offset of the values [levels].
    """

    deviation: float
    offset: float

    def expected(self, counts: Counts, centre: float, power: int) -> tuple[float, float]:
        """Return the expected value and the variance of the sum of a power of the errors about a value.

        Args:
            counts: Number of values of each level, shape (256,).
            centre: The value [levels].
            power: The power.
        """
        errors = (LEVELS[None, :] - LEVELS[:, None] - centre) ** power
        probabilities = _probabilities(self.deviation, self.offset)
        means = (probabilities * errors).sum(axis=1)
        variances = (probabilities * errors**2).sum(axis=1) - means**2
        return float(counts @ means), max(0.0, float(counts @ variances))


@lru_cache(maxsize=16)
def _probabilities(deviation: float, offset: float) -> Array:
    """Return the probabilities by true level and resulting level."""
    from scipy.special import ndtr  # noqa: PLC0415 - slow to load, and seldom needed

    middle = LEVELS + offset
    if deviation == 0.0:
        certain: Array = (np.clip(np.rint(middle), 0, BRIGHTEST)[:, None] == LEVELS).astype(np.float64)
        return certain
    borders = np.concatenate(([-np.inf], LEVELS[1:] - 0.5, [np.inf]))
    probabilities: Array = np.diff(ndtr((borders[None, :] - middle[:, None]) / deviation), axis=1)
    return probabilities
