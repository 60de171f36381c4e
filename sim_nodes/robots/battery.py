"""The battery of a base, with one constant power draw at rest and another while driving.

Nothing else draws power, and nothing charges it. At a charge of 0, the robot keeps working.
"""

from __future__ import annotations

from sim_nodes.robots.declaration import BatteryDeclaration
from sim_nodes.stateful import Stateful
from sim_nodes.ticks import TICK

HOUR = 3600.0  # [s]


class Battery(Stateful):
    """A battery.

    Args:
        declaration: Declaration of the battery.
    """

    STATE = ("_tick", "_standing", "_driving")

    def __init__(self, declaration: BatteryDeclaration) -> None:
        self._declaration = declaration
        self._tick = 0  # of the last update
        # Ticks are counted, so that the charge does not depend on the number of updates.
        self._standing = 0
        self._driving = 0

    def update(self, tick: int, *, drives: bool) -> None:
        """Update with whether the base has driven since the last update."""
        passed, self._tick = tick - self._tick, tick
        if drives:
            self._driving += passed
        else:
            self._standing += passed

    @property
    def charge(self) -> float:
        """Charge from 0 to 1 at the last update."""
        declared = self._declaration
        drawn = (self._standing * declared.idle + self._driving * declared.driving) * TICK / HOUR  # [Wh]
        return max(0.0, declared.charge - drawn / declared.capacity)
