"""The obstacle layer: objects seen by the lidar that are not on the map.

Each cell counts the scans that hit it minus the scans that passed through it. So a stray beam does not create an
obstacle, and a missed one does not remove it. Hits next to walls of the map belong to the walls.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim_nodes.geometry import Array, Pose2
from sim_nodes.navigation.maps import FAR, NavigationMap
from sim_nodes.sensors.lidar import Scan
from sim_nodes.stateful import Stateful

HITS = 3  # net number of scans with a hit that make an obstacle
MOST = 8  # limit of the count, so that obstacles that leave are cleared in about a second
RANGE = 3.0  # [m] up to which scans are used
WALL_BAND = 0.15  # [m] from a wall of the map within which hits belong to it
MARGIN = 0.1  # [m] before a hit that a beam does not clear
STRIDE = 0.05  # [m] between cleared points of a beam


class ObstacleLayer(Stateful):
    """Counts of hits on the grid of a map, and distances to the obstacles.

    Attributes:
        distance: Distance of each cell to the nearest wall or obstacle [m].
        changes: Number of changes of the set of obstacles.
    """

    STATE = ("changes", "_count", "_obstacles", "distance")

    def __init__(self, known: NavigationMap) -> None:
        self._map = known
        self._free = known.distance > WALL_BAND
        self._steps = np.arange(0.2, RANGE, STRIDE)
        self.changes = 0
        self.clear()

    def clear(self) -> None:
        """Clear all obstacles."""
        self._count = np.zeros(self._map.distance.shape, dtype=np.int8)
        self._obstacles = np.zeros(self._map.distance.shape, dtype=np.bool_)
        self.distance = self._map.distance
        self.changes += 1

    def update(self, pose: Pose2, scan: Scan) -> None:
        """Update with a scan at a pose of the base in `map`."""
        seen = np.zeros(self._count.shape, dtype=np.bool_)
        hit = np.zeros(self._count.shape, dtype=np.bool_)
        lidar = pose.compose(scan.mount)
        angles = scan.angles + pose.yaw
        cos, sin = np.cos(angles), np.sin(angles)
        self._mark_seen(seen, lidar, scan, cos, sin)
        near = scan.ranges < RANGE
        x = lidar.x + scan.ranges[near] * cos[near]
        y = lidar.y + scan.ranges[near] * sin[near]
        inside = self._map.grid.inside(x, y)
        hit[self._map.grid.cells(x[inside], y[inside])] = True
        hit &= self._free
        self._count[seen & ~hit & (self._count > 0)] -= 1
        self._count[hit & (self._count < MOST)] += 1
        obstacles = self._count >= HITS
        if not np.array_equal(obstacles, self._obstacles):
            self._obstacles = obstacles
            self.changes += 1
            self.distance = self._distances()

    def _mark_seen(self, seen: NDArray[np.bool_], lidar: Pose2, scan: Scan, cos: Array, sin: Array) -> None:
        reach = np.minimum(scan.ranges, RANGE) - MARGIN
        beam, step = np.nonzero(self._steps[None, :] < reach[:, None])
        x = lidar.x + self._steps[step] * cos[beam]
        y = lidar.y + self._steps[step] * sin[beam]
        seen[self._map.grid.cells(x, y)] = True

    def _distances(self) -> Array:
        if not self._obstacles.any():
            return self._map.distance
        from scipy.ndimage import distance_transform_edt  # noqa: PLC0415 - slow to load

        resolution = self._map.grid.resolution
        # The transform measures between centres; an obstacle begins at the border of its cell.
        distance = distance_transform_edt(~self._obstacles) * resolution - resolution / 2
        combined: Array = np.minimum(self._map.distance, distance.clip(0.0, FAR))
        return combined
