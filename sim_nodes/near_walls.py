"""The nearest of the few walls around a place, in numbers of Python, which take less time than small arrays."""

from __future__ import annotations

import math
from typing import NamedTuple

from seoro.deferred import dataclass


class PlacedWall(NamedTuple):
    """A wall: name, centre [m], cosine and sine of its yaw, and halves of its length and thickness [m]."""

    name: str
    x: float
    y: float
    cos: float
    sin: float
    half_length: float
    half_thickness: float


@dataclass(frozen=True)
class NearWalls:
    """The walls that may be the nearest ones of places around a place.

    Attributes:
        x, y: The place [m].
        reach: Distance up to which other places are around it [m].
        walls: The walls.
    """

    x: float
    y: float
    reach: float
    walls: tuple[PlacedWall, ...]

    def covers(self, x: float, y: float) -> bool:
        """Whether a place is around that of the walls."""
        return math.hypot(x - self.x, y - self.y) < self.reach

    def nearest(self, x: float, y: float) -> tuple[float, str]:
        """Return the distance of a covered place to the nearest wall [m], and its name; infinite without walls."""
        best, nearest = math.inf, ""
        for name, centre_x, centre_y, cos, sin, half_length, half_thickness in self.walls:
            dx, dy = x - centre_x, y - centre_y
            along = abs(cos * dx + sin * dy) - half_length
            across = abs(cos * dy - sin * dx) - half_thickness
            # As `numpy.hypot`, unlike `math.hypot`, which rounds in another way.
            distance = abs(complex(max(along, 0.0), max(across, 0.0)))
            if distance < best:
                best, nearest = distance, name
        return best, nearest
