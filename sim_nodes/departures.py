"""Robots that are where none can be: outside of their world, far from its floor, or nowhere.

The floor of a world ends at its extent, and so does the map of its robots: what happens beyond means nothing.
"""

from __future__ import annotations

import math

from seoro.bridges.wire import Departure, Vector3
from sim_nodes.geometry import Vector
from sim_nodes.physics import BodyState, UnstablePhysics
from sim_nodes.stateful import Stateful

Extent = tuple[float, float, float, float]

HEIGHTS = (-0.5, 20.0)  # [m] of bases above the floor; engines throw up what was forced deep into it


class Departures(Stateful):
    """Finds robots that leave a world, each once until it is back.

    Args:
        extent: Lower x, lower y, upper x, upper y of the world [m].
    """

    STATE = ("_outside",)

    def __init__(self, extent: Extent) -> None:
        self._extent = extent
        self._outside: frozenset[str] = frozenset()

    def find(self, robot: str, position: Vector, time: float) -> Departure | None:
        """Report that a robot has left the world since the last look.

        Args:
            robot: Name of the robot.
            position: Of its base in the map [m].
            time: Of the clock [s].
        """
        if is_within(position, self._extent):
            self._outside -= {robot}
            return None
        if robot in self._outside:
            return None
        self._outside |= {robot}
        x, y, z = position
        return Departure(time=time, robot=robot, position=Vector3(x=x, y=y, z=z), extent=self._extent)


def is_within(position: Vector, extent: Extent) -> bool:
    """Return whether a position [m] is above or below the extent of a world."""
    left, lower, right, upper = extent
    return left <= position[0] <= right and lower <= position[1] <= upper


def check_state(robot: str, state: BodyState, time: float) -> None:
    """Check that the physics has kept a robot near the floor, at a finite state.

    Args:
        robot: Name of the robot.
        state: Of its base.
        time: Of the clock [s].

    Raises:
        UnstablePhysics: It is far from the floor, or its state is not finite.
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
