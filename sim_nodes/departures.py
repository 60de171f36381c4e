"""Detects robots that leave the world.

The floor ends at the extent of a world, and so do the maps of its robots.
"""

from __future__ import annotations

import math

from seoro.bridges.wire import Departure, Position3D
from sim_nodes.geometry import Vector
from sim_nodes.physics import BodyState, UnstablePhysics
from sim_nodes.stateful import Stateful

Extent = tuple[float, float, float, float]

HEIGHTS = (-0.5, 20.0)  # [m] of bases above the floor; engines throw up bodies that overlap it deeply


class Departures(Stateful):
    """Detects each departure once, until the robot returns.

    Args:
        extent: Lower x, lower y, upper x, upper y of the world [m].
    """

    STATE = ("_outside",)

    def __init__(self, extent: Extent) -> None:
        self._extent = extent
        self._outside: frozenset[str] = frozenset()

    def find(self, robot: str, position: Vector, time: float) -> Departure | None:
        """Return the departure of a robot if it has left the world since the last call.

        Args:
            robot: Name of the robot.
            position: Position of its base in `map` [m].
            time: Simulation time [s].
        """
        if is_within(position, self._extent):
            if self._outside:
                self._outside -= {robot}
            return None
        if robot in self._outside:
            return None
        self._outside |= {robot}
        return Departure(time=time, robot=robot, position=Position3D(*position), extent=self._extent)


def is_within(position: Vector, extent: Extent) -> bool:
    """Whether a position [m] is above or below the extent of a world."""
    left, lower, right, upper = extent
    return left <= position[0] <= right and lower <= position[1] <= upper


def check_state(robot: str, state: BodyState, time: float) -> None:
    """Check that the physics has kept a robot near the floor, at a finite state.

    Args:
        robot: Name of the robot.
        state: State of its base.
        time: Simulation time [s].

    Raises:
        UnstablePhysics: The robot is far from the floor, or its state is not finite.
    """
    if not all(map(math.isfinite, (*state.position, *state.orientation))):
        raise UnstablePhysics(f"the state of the robot '{robot}' is not finite at {time:g} s")
    lowest, highest = HEIGHTS
    if not lowest <= state.position[2] <= highest:
        where = "({:.3f}, {:.3f}, {:.3f}) m".format(*state.position)
        raise UnstablePhysics(
            f"the physics lost the robot '{robot}': it is at {where} at {time:g} s; "
            f"expected a height from {lowest:g} m to {highest:g} m"
        )
