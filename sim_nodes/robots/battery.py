"""The battery of a base: energy from which it takes one power while it stands, and another while it drives.

Nothing else draws from it, and nothing charges it. What a robot does whose battery is empty is a matter of its
makers; here the charge stays 0 then, and the robot goes on.
"""

from __future__ import annotations

from sim_nodes.robots.declaration import BatteryDeclaration
from sim_nodes.stateful import Stateful
from sim_nodes.ticks import TICK

HOUR = 3600.0  # [s]


class Battery(Stateful):
    """A battery.

    Args:
        declaration: What is declared of it.
    """

    STATE = ("_tick", "_standing", "_driving")

    def __init__(self, declaration: BatteryDeclaration) -> None:
        self._declaration = declaration
        self._tick = 0  # of the last look
        # Ticks are counted, so that the charge does not depend on how often it was looked.
        self._standing = 0
        self._driving = 0

    def pass_tick(self, tick: int, *, drives: bool) -> None:
        """Note whether the base has driven since the last look."""
        passed, self._tick = tick - self._tick, tick
        if drives:
            self._driving += passed
        else:
            self._standing += passed

    @property
    def charge(self) -> float:
        """From 0 to 1, at the last look."""
        declared = self._declaration
        drawn = (self._standing * declared.idle + self._driving * declared.driving) * TICK / HOUR  # [Wh]
        return max(0.0, declared.charge - drawn / declared.capacity)
