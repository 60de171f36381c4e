"""The obstacle layer: objects seen by the lidar that are not on the map.

Each cell counts the scans that hit it minus the scans that passed through it. So a stray beam does not create an
obstacle, and a missed one does not remove it. Hits next to walls of the map belong to the walls. Cells keep the
mean place of their hits, so that distances are more precise than cells.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from sim_nodes.geometry import Array, Indices, Pose2
from sim_nodes.navigation.maps import NavigationMap
from sim_nodes.sensors.lidar import Scan
from sim_nodes.stateful import Stateful

HITS = 3  # net number of scans with a hit that make an obstacle
MOST = 8  # limit of the count, so that obstacles that leave are cleared in about a second
RANGE = 3.0  # [m] up to which scans are used
WALL_BAND = 0.15  # [m] from a wall of the map within which hits belong to it
MARGIN = 0.1  # [m] before a hit that a beam does not clear
SAFETY = 0.035  # [m] by which obstacles are taken to be nearer than their points, because cells are a sample
SHARE = 0.3  # of the latest hits in the mean place of a cell


class ObstacleLayer(Stateful):
    """Counts of hits on the grid of a map.

    Attributes:
        changes: Number of changes of the set of obstacles.
    """

    STATE = ("changes", "_cells", "_counts", "_places")

    def __init__(self, known: NavigationMap) -> None:
        self._map = known
        self._framed = known.grid.framed()
        # With a border, in which points beyond the map are.
        self._is_free = np.pad(known.distance > WALL_BAND, 1, constant_values=False)
        self.changes = 0
        self.clear()

    def clear(self) -> None:
        """Clear all obstacles."""
        self._cells: Indices = np.zeros(0, dtype=np.int64)  # with a count, sorted, as indices of the flat grid
        self._counts: Indices = np.zeros(0, dtype=np.int64)
        self._places = np.zeros((0, 2))  # mean places of the hits of each cell [m]
        self.changes += 1

    @property
    def points(self) -> Array:
        """Points of obstacles in `map`, one for each cell, shape (n, 2) [m]."""
        points: Array = self._places[self._counts >= HITS]
        return points

    def update(self, pose: Pose2, scan: Scan) -> None:
        """Update with a scan at a pose of the base in `map`."""
        before = self._cells[self._counts >= HITS]
        hits, places = self._hits(pose, scan)
        counts = self._counts - self._seen_through(pose, scan)
        if len(hits):
            self._merge(counts, hits, places)
        else:
            self._keep(self._cells, counts, self._places)
        if not np.array_equal(before, self._cells[self._counts >= HITS]):
            self.changes += 1

    def _hits(self, pose: Pose2, scan: Scan) -> tuple[Indices, Array]:
        """Return the cells that a scan hits, sorted, and the mean place of the hits of each."""
        near = scan.ranges < RANGE
        cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
        bx, by = scan.x[near], scan.y[near]
        x, y = pose.x + cos * bx - sin * by, pose.y + sin * bx + cos * by
        columns, rows = self._framed.cells(x, y)
        apart = np.flatnonzero(self._is_free[columns, rows])
        if len(apart) == 0:
            return np.zeros(0, dtype=np.int64), np.zeros((0, 2))
        # Like `unique` with inverse and counts, which takes twice as long for few values.
        found = (columns[apart] - 1) * self._map.grid.rows + rows[apart] - 1
        order = np.argsort(found, kind="stable")
        found = found[order]
        firsts = np.flatnonzero(np.concatenate(([True], found[1:] != found[:-1])))
        places = np.column_stack([x[apart], y[apart]])[order]
        counts = np.diff(np.append(firsts, len(found)))
        return found[firsts], np.add.reduceat(places, firsts) / counts[:, None]

    def _merge(self, counts: Indices, hits: Indices, places: Array) -> None:
        """Merge hits: one for each cell, which did not see through it."""
        at = np.searchsorted(self._cells, hits)
        known = np.zeros(len(hits), dtype=np.bool_)
        if len(self._cells):
            known = self._cells[np.minimum(at, len(self._cells) - 1)] == hits
        old, new = at[known], ~known
        counts[old] = np.minimum(self._counts[old] + 1, MOST)
        mean = self._places.copy()
        mean[old] += SHARE * (places[known] - mean[old])
        cells = np.concatenate([self._cells, hits[new]])
        counts = np.concatenate([counts, np.ones(int(new.sum()), dtype=np.int64)])
        mean = np.concatenate([mean, places[new]])
        order = np.argsort(cells, kind="stable")
        self._keep(cells[order], counts[order], mean[order])

    def _keep(self, cells: Indices, counts: Indices, places: Array) -> None:
        kept = counts > 0
        self._cells, self._counts, self._places = cells[kept], counts[kept], places[kept]

    def _seen_through(self, pose: Pose2, scan: Scan) -> NDArray[np.bool_]:
        """Return whether a beam passed through each cell."""
        if len(self._cells) == 0:
            return np.zeros(0, dtype=np.bool_)
        lidar = pose.compose(scan.mount)
        distances = np.hypot(self._places[:, 0] - lidar.x, self._places[:, 1] - lidar.y)
        through: NDArray[np.bool_] = np.minimum(self._ranges_there(pose, scan), RANGE) - MARGIN > distances
        return through

    def _ranges_there(self, pose: Pose2, scan: Scan) -> Array:
        """Return the range of the beam towards each cell [m]."""
        lidar = pose.compose(scan.mount)
        bearings = np.arctan2(self._places[:, 1] - lidar.y, self._places[:, 0] - lidar.x)
        count = len(scan.ranges)
        turns = (bearings - pose.yaw - scan.angles[0]) / (2.0 * math.pi)
        ranges: Array = scan.ranges[np.rint(turns * count).astype(np.int64) % count]
        return ranges

    def hidden_points(self, pose: Pose2, scan: Scan) -> Array:
        """Return the points of obstacles that a scan does not see, shape (n, 2) [m]."""
        if len(self._cells) == 0 or scan.is_complete:
            return self._places[:0]
        hidden = ~np.isfinite(self._ranges_there(pose, scan)) & (self._counts >= HITS)
        points: Array = self._places[hidden]
        return points

    def distance(self, reach: float) -> Array:
        """Return the distance of each cell to the nearest wall or obstacle [m], shape (columns, rows).

        Args:
            reach: Distance up to which obstacles count [m].
        """
        points = self.points
        if len(points) == 0:
            return self._map.distance
        from scipy.ndimage import distance_transform_edt  # noqa: PLC0415 - slow to load

        grid, combined = self._map.grid, self._map.distance.copy()
        cells = np.array(np.divmod(self._cells[self._counts >= HITS], grid.rows))
        border = math.ceil(reach / grid.resolution)
        low = np.maximum(cells.min(axis=1) - border, 0)
        high = np.minimum(cells.max(axis=1) + border + 1, combined.shape)
        near = (slice(low[0], high[0]), slice(low[1], high[1]))
        where = tuple(cells - low[:, None])
        size = tuple((high - low).tolist())
        numbers, empty = np.zeros(size, dtype=np.int64), np.ones(size, dtype=np.bool_)
        numbers[where], empty[where] = np.arange(len(points)), False
        nearest = distance_transform_edt(empty, return_distances=False, return_indices=True)
        x, y = points[numbers[nearest[0], nearest[1]]].transpose(2, 0, 1)
        away_x = grid.x + (np.arange(low[0], high[0]) + 0.5)[:, None] * grid.resolution - x
        away_y = grid.y + (np.arange(low[1], high[1]) + 0.5) * grid.resolution - y
        distance = np.maximum(np.sqrt(away_x**2 + away_y**2) - SAFETY, 0.0)
        combined[near] = np.where(distance <= reach, np.minimum(combined[near], distance), combined[near])
        return combined
