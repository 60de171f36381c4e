"""Travel of a door or a lift: its position between two ends, its speed, its target, and obstacles.

The position of a door is its opening, from 0 to 1; that of a lift its height [m]. Rates are per second.
"""

from __future__ import annotations

import math
from dataclasses import replace

from seoro.deferred import dataclass
from sim_nodes.ticks import TICK

BRAKING = 0.8  # share of the acceleration with which it brakes
PAUSE_TICKS = 50  # that it stands after it met an obstacle
PATIENCE = round(5.0 / TICK)  # ticks without progress after which a goal is aborted
PROGRESS = 0.02  # of the way from end to end


@dataclass(frozen=True)
class Limits:
    """Limits of a travel: rate [1/s], acceleration [1/s^2], and the length of the way from end to end."""

    rate: float
    acceleration: float
    length: float = 1.0


@dataclass(frozen=True)
class Travel:
    """The travel of a door or a lift.

    Attributes:
        position: Present position.
        target: Position to reach.
        rate: Present rate.
        goal: Id of the goal; None without a client that waits.
        obstacle: Entity in its way at the last try; empty for none.
        resumes: Tick until which it stands after an obstacle.
        reached: Position at the last progress.
        since: Tick of the last progress.
    """

    position: float
    target: float
    rate: float = 0.0
    goal: str | None = None
    obstacle: str = ""
    resumes: int = 0
    reached: float = 0.0
    since: int = 0

    @property
    def has_arrived(self) -> bool:
        """Whether it is at its target."""
        return self.position == self.target and self.rate == 0.0

    def towards(self, target: float, tick: int, goal: str | None = None) -> Travel:
        """Return the travel to another target, from a tick on."""
        return replace(self, target=target, goal=goal, obstacle="", resumes=0, reached=self.position, since=tick)

    def stopped(self) -> Travel:
        """Return the travel that ends here, without a goal."""
        return replace(self, target=self.position, rate=0.0, goal=None)

    def advanced(self, limits: Limits, tick: int) -> Travel:
        """Return the travel at the next tick, if nothing is in its way."""
        if self.has_arrived or tick < self.resumes:
            return self
        left = self.target - self.position
        fastest = min(limits.rate, math.sqrt(2.0 * BRAKING * limits.acceleration * abs(left)))
        step = limits.acceleration * TICK
        rate = min(max(math.copysign(fastest, left), self.rate - step), self.rate + step)
        if rate * left > 0.0 and abs(rate) * TICK >= abs(left):
            return replace(self, position=self.target, rate=0.0, obstacle="")
        position = self.position + rate * TICK
        moved = abs(position - self.reached) >= PROGRESS * limits.length
        return replace(
            self,
            position=position,
            rate=rate,
            obstacle="" if moved else self.obstacle,
            reached=position if moved else self.reached,
            since=tick if moved else self.since,
        )

    def blocked(self, obstacle: str, position: float, tick: int) -> Travel:
        """Return the travel that stands at a position for a while, before an obstacle."""
        return replace(self, position=position, rate=0.0, obstacle=obstacle, resumes=tick + PAUSE_TICKS)
