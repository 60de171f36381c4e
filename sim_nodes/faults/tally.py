"""Counting what was found against what a fault leads one to expect."""

from __future__ import annotations

import math
from dataclasses import dataclass

from sim_nodes.stateful import Stateful

ROUNDING = 1e-9


@dataclass(frozen=True)
class Demand:
    """When a tally is good enough.

    Args:
        deviations: Standard deviations that what is found may be off by.
        precision: Largest share of the fault's effect that this tolerance may be.
        least: Values to be counted at least.
    """

    deviations: float
    precision: float
    least: int


VALUES = Demand(deviations=4.0, precision=0.5, least=20)
MESSAGES = Demand(deviations=3.0, precision=1.0, least=10)  # there are few of them


class Tally(Stateful):
    """A sum over what was found, the sums expected of it with and without the fault, and its variance."""

    STATE = ("count", "found", "expected", "sound", "_variance")

    def __init__(self, demand: Demand) -> None:
        self._demand = demand
        self._variance = 0.0
        self.count = 0
        self.found = 0.0
        self.expected = 0.0
        self.sound = 0.0  # expected without the fault

    def add(self, count: int, found: float, expected: float, sound: float, variance: float) -> None:
        """Count values."""
        self.count += count
        self.found += found
        self.expected += expected
        self.sound += sound
        self._variance += variance

    @property
    def fits(self) -> bool:
        """Whether what was found may be what the fault makes."""
        return abs(self.found - self.expected) <= self._tolerance

    @property
    def holds(self) -> bool:
        """Whether what was found is what the fault makes, and neither nothing nor half as much would be."""
        effect = abs(self.expected - self.sound)
        return (
            self.fits and self.count >= self._demand.least and self._tolerance <= self._demand.precision * effect
        )

    @property
    def _tolerance(self) -> float:
        return self._demand.deviations * math.sqrt(self._variance) + ROUNDING * (1.0 + abs(self.expected))
