"""Walls for agents, by the distance field of the map."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from sim_nodes.agents.agent import Point
from sim_nodes.geometry import Array
from sim_nodes.navigation.maps import NavigationMap

SPACING = 0.05  # [m] between the checked points of a line
BLUR = 0.02  # [m] error of interpolated distances


class Walls:
    """Distances to the walls of a map.

    Args:
        known: The map.
    """

    def __init__(self, known: NavigationMap) -> None:
        self._grid, self._distance = known.grid, known.distance
        step = known.grid.resolution
        around = ((0.0, 0.0), (step, 0.0), (-step, 0.0), (0.0, step), (0.0, -step))
        self._around = np.array(around)[:, None]  # of a point, to find the slope there

    def distances(self, points: Array) -> Array:
        """Return the distances of points of shape (n, 2) to the nearest wall, shape (n,) [m]."""
        return self._grid.interpolate(self._distance, points[:, 0], points[:, 1])

    def nearest(self, points: Array) -> tuple[Array, Array]:
        """Return distances [m] and the directions away from the nearest wall, of shapes (n,) and (n, 2).

        The directions are unit vectors, or zero where no wall is near.
        """
        found = self.distances((self._around + points).reshape(-1, 2)).reshape(5, len(points))
        slope = found[1::2] - found[2::2]
        norm = np.hypot(*slope)
        away: Array = (slope / np.where(norm > 0.0, norm, 1.0)).T
        return found[0], away

    def describe_block(self, line: Sequence[Point], needed: float) -> str:
        """Describe the wall or border that blocks a line; empty if it is clear.

        Args:
            line: Points of the line; a start beside a wall is allowed if the line leads away from it.
            needed: Distance to keep from walls [m].
        """
        for x, y in line:
            if not self.is_inside((x, y)):
                return f"({x:g}, {y:g}) is outside of the world; expected a point of its map"
        for index, (start, end) in enumerate(pairwise(line)):
            found = self._narrowest(start, end, needed, leaves=index == 0)
            if found is not None:
                x, y, distance = found
                way = f"from ({start[0]:g}, {start[1]:g}) to ({end[0]:g}, {end[1]:g})"
                return (
                    f"the way {way} is {distance:.2f} m from a wall at ({x:.2f}, {y:.2f}); "
                    f"expected {needed:g} m or more: add points around it"
                )
        return ""

    def is_clear(self, start: Point, end: Point, needed: float) -> bool:
        """Whether a line is on the map, and nowhere nearer to a wall than needed [m]."""
        return self.is_inside(end) and self._narrowest(start, end, needed, leaves=True) is None

    def is_inside(self, point: Point) -> bool:
        """Whether a point is on the map."""
        return self._grid.contains(*point)

    def _narrowest(
        self, start: Point, end: Point, needed: float, *, leaves: bool
    ) -> tuple[float, float, float] | None:
        """Return the first point of a line that is too near to a wall, and its distance; None without one."""
        share = np.linspace(0.0, 1.0, 2 + math.ceil(math.dist(start, end) / SPACING))[:, None]
        points = np.array(start) + (np.array(end) - start) * share
        distances = self.distances(points)
        near = distances < needed - BLUR
        if leaves:
            near &= ~np.logical_and.accumulate(near & (np.diff(distances, append=np.inf) > 0.0))
        if not near.any():
            return None
        x, y = points[near.argmax()].tolist()
        return x, y, float(distances[near.argmax()])
