"""Watches of doors and lifts."""

from __future__ import annotations

from seoro.deferred import dataclass
from sim_nodes.watches import Watch, Watched


@dataclass(frozen=True)
class PositionWatch(Watch):
    """True when the opening of a door, or the height of a lift [m], is in a range."""

    part: str
    least: float
    most: float

    def holds(self, world: Watched) -> bool:
        """Whether the condition is true."""
        position = world.building_position(self.part)
        return position is not None and self.least <= position <= self.most
