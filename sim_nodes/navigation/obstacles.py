"""The obstacle layer: objects that are not on the map, seen by the lidar or touched by the bumper.

Each cell counts the scans that hit it minus the scans that passed through it. So a stray beam does not create an
obstacle, and a missed one does not remove it. Hits next to walls of the map belong to the walls. Cells keep the
mean place of their hits, so that distances are more precise than cells.

A touched place is an obstacle that is cleared by many scans through it only: the lidar may not see what the
bumper touches. It counts also next to walls of the map, which are elsewhere if the localisation is wrong. Next to
a seen obstacle it is a part of that, and is cleared with it: other robots drive on.

Layers of robots that have scans in the same tick are updated together; the results are those of each one alone.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from seoro.deferred import dataclass
from sim_nodes.geometry import Array, Indices, Pose2
from sim_nodes.navigation.maps import NavigationMap
from sim_nodes.navigation.nearest import nearest_cells
from sim_nodes.sensors.lidar import Scan
from sim_nodes.stateful import Stateful

HITS = 3  # net number of scans with a hit that make an obstacle
MOST = 8  # limit of the count, so that obstacles that leave are cleared in about a second
TOUCHED = 150  # count of a touched place
SEEN = (
    0.2  # [m] from a seen obstacle within which a touched place is a part of it; lidars see parts of robots only
)
RANGE = 3.0  # [m] up to which scans are used
WALL_BAND = 0.15  # [m] from a wall of the map within which hits belong to it
MARGIN = 0.1  # [m] before a hit that a beam does not clear
SAFETY = 0.035  # [m] by which obstacles are taken to be nearer than their points, because cells are a sample
SHARE = 0.3  # of the latest hits in the mean place of a cell


class ObstacleLayer(Stateful):
    """Counts of hits on the grid of a map.

    Attributes:
        known: The map.
        changes: Number of changes of the set of obstacles.
    """

    STATE = ("changes", "_cells", "_counts", "_places")

    def __init__(self, known: NavigationMap) -> None:
        self.known = known
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
    def _is_touched(self) -> NDArray[np.bool_]:
        return self._counts > MOST

    def clear_seen(self) -> None:
        """Clear the obstacles that were only seen."""
        self._keep(self._is_touched)

    def clear_touched(self) -> bool:
        """Clear the touched places; returns whether there were any."""
        touched = self._is_touched
        if not touched.any():
            return False
        self._keep(~touched)
        return True

    def _keep(self, kept: NDArray[np.bool_]) -> None:
        self._cells, self._counts, self._places = self._cells[kept], self._counts[kept], self._places[kept]
        self.changes += 1

    def touch(self, places: Array) -> None:
        """Add touched places in `map`, shape (n, 2) [m]; those beyond the map are ignored."""
        grid = self.known.grid
        columns, rows = grid.cells(*places.T)
        cells, firsts = np.unique(columns * grid.rows + rows, return_index=True)
        inside = grid.inside(*places[firsts].T)
        cells, places = cells[inside], places[firsts[inside]]
        counts = np.where(self._is_near_seen(places), MOST, TOUCHED)
        others = ~np.isin(self._cells, cells)
        is_new = not np.isin(cells, self._cells[self._counts >= HITS]).all()
        order = np.argsort(np.concatenate([self._cells[others], cells]), kind="stable")
        self._cells = np.concatenate([self._cells[others], cells])[order]
        self._counts = np.concatenate([self._counts[others], counts])[order]
        self._places = np.concatenate([self._places[others], places])[order]
        self.changes += is_new

    def _is_near_seen(self, places: Array) -> NDArray[np.bool_]:
        """Return which places are next to a seen obstacle, shape (n,)."""
        seen = self._places[(self._counts >= HITS) & ~self._is_touched]
        apart = np.linalg.norm(places[:, None] - seen[None], axis=2)
        near: NDArray[np.bool_] = apart.min(axis=1, initial=np.inf) < SEEN
        return near

    @property
    def points(self) -> Array:
        """Points of obstacles in `map`, one for each cell, shape (n, 2) [m]."""
        points: Array = self._places[self._counts >= HITS]
        return points

    def update(self, pose: Pose2, scan: Scan) -> None:
        """Update with a scan at a pose of the base in `map`."""
        update_together([Observation(self, pose, scan)])

    def hidden_points(self, pose: Pose2, scan: Scan) -> Array:
        """Return the points of obstacles that a scan does not see, and touched places, shape (n, 2) [m]."""
        if len(self._cells) == 0:
            return self._places[:0]
        touched = self._is_touched
        if scan.is_complete:
            return self._places[touched]
        sight = _Sight([Observation(self, pose, scan)])
        beams = sight.beams(self._places, np.zeros(len(self._cells), dtype=np.int64))
        hidden = (~np.isfinite(scan.ranges[beams]) & (self._counts >= HITS)) | touched
        points: Array = self._places[hidden]
        return points

    def _hits(self, x: Array, y: Array, robots: Indices) -> tuple[Indices, Array]:
        """Return the cells of points of robots, numbered as in `_update`, and the mean place of points in each."""
        columns, rows = self._framed.cells(x, y)
        apart = np.flatnonzero(self._is_free[columns, rows])
        if len(apart) == 0:
            return np.zeros(0, dtype=np.int64), np.zeros((0, 2))
        # Like `unique` with inverse and counts, which takes twice as long for few values.
        found = (columns[apart] - 1) * self.known.grid.rows + rows[apart] - 1
        found += robots[apart] * self.known.distance.size
        order = np.argsort(found, kind="stable")
        found = found[order]
        firsts = np.flatnonzero(np.concatenate(([True], found[1:] != found[:-1])))
        places = np.column_stack([x[apart], y[apart]])[order]
        counts = np.diff(np.append(firsts, len(found)))
        return found[firsts], np.add.reduceat(places, firsts) / counts[:, None]

    def distance(self, reach: float) -> Array:
        """Return the distance of each cell to the nearest wall or obstacle [m], shape (columns, rows).

        Args:
            reach: Distance up to which obstacles count [m].
        """
        points = self.points
        if len(points) == 0:
            return self.known.distance
        grid, combined = self.known.grid, self.known.distance.copy()
        cells = np.array(np.divmod(self._cells[self._counts >= HITS], grid.rows))
        border = math.ceil(reach / grid.resolution)
        low = np.maximum(cells.min(axis=1) - border, 0)
        high = np.minimum(cells.max(axis=1) + border + 1, combined.shape)
        near = (slice(low[0], high[0]), slice(low[1], high[1]))
        # Points are up to half a diagonal beside the centres of their cells.
        cell_reach = math.ceil((reach + SAFETY) / grid.resolution + 0.71)
        nearest = nearest_cells(cells - low[:, None], (int(high[0] - low[0]), int(high[1] - low[1])), cell_reach)
        x, y = points[nearest].transpose(2, 0, 1)
        away_x = grid.x + (np.arange(low[0], high[0]) + 0.5)[:, None] * grid.resolution - x
        away_y = grid.y + (np.arange(low[1], high[1]) + 0.5) * grid.resolution - y
        distance = np.maximum(np.sqrt(away_x**2 + away_y**2) - SAFETY, 0.0)
        combined[near] = np.where(
            (nearest >= 0) & (distance <= reach), np.minimum(combined[near], distance), combined[near]
        )
        return combined


@dataclass(frozen=True)
class Observation:
    """A scan for a layer, at a pose of the base in `map`."""

    layer: ObstacleLayer
    pose: Pose2
    scan: Scan


def update_together(observations: Sequence[Observation]) -> None:
    """Update layers with scans."""
    kinds: dict[tuple[int, int], list[Observation]] = defaultdict(list)
    for each in observations:
        kinds[id(each.layer.known), len(each.scan.ranges)].append(each)
    for some in kinds.values():
        _update([each.layer for each in some], _Sight(some))


class _Sight:
    """The scans of robots with one map and equally many beams.

    Args:
        observations: The scans. The position in this sequence is the number of a robot.
    """

    def __init__(self, observations: Sequence[Observation]) -> None:
        poses, scans = [each.pose for each in observations], [each.scan for each in observations]
        turns = [(math.cos(pose.yaw), math.sin(pose.yaw)) for pose in poses]
        self._observations = observations
        self._poses, self._turns = np.array(poses), np.array(turns)
        self.ranges = np.array([scan.ranges for scan in scans])  # [m], shape (robots, beams)
        self._x, self._y = np.array([scan.x for scan in scans]), np.array([scan.y for scan in scans])

    @cached_property
    def _lidars(self) -> Array:
        """Poses of the lidars in `map`, shape (robots, 3)."""
        return np.array([each.pose.compose(each.scan.mount) for each in self._observations])

    @cached_property
    def _starts(self) -> Array:
        """Bearings of the first beams, shape (robots,) [rad]."""
        return np.array([each.scan.angles[0] for each in self._observations])

    def ends(self) -> tuple[Array, Array, Indices]:
        """Return the near ends of beams in `map` x, y [m], and their robots, robot by robot."""
        near = self.ranges < RANGE
        robots = np.nonzero(near)[0]
        bx, by = self._x[near], self._y[near]
        (x, y, _), (cos, sin) = self._poses.T[:, robots], self._turns.T[:, robots]
        return x + cos * bx - sin * by, y + sin * bx + cos * by, robots

    def beams(self, places: Array, robots: Indices) -> Indices:
        """Return the beam of a robot towards each place, shape (n,)."""
        lidars = self._lidars[robots]
        bearings = np.arctan2(places[:, 1] - lidars[:, 1], places[:, 0] - lidars[:, 0])
        count = self.ranges.shape[1]
        turns = (bearings - self._poses[robots, 2] - self._starts[robots]) / (2.0 * math.pi)
        beams: Indices = np.rint(turns * count).astype(np.int64) % count
        return beams

    def through(self, places: Array, robots: Indices) -> NDArray[np.bool_]:
        """Return whether a beam of a robot passed through each place."""
        if len(places) == 0:
            return np.zeros(0, dtype=np.bool_)
        away = places - self._lidars[robots, :2]
        ranges = self.ranges[robots, self.beams(places, robots)]
        seen: NDArray[np.bool_] = np.minimum(ranges, RANGE) - MARGIN > np.hypot(away[:, 0], away[:, 1])
        return seen


def _update(layers: Sequence[ObstacleLayer], sight: _Sight) -> None:
    """Update layers of one map.

    Cells of all layers are in one array, sorted: their number is the flat index on the grid, plus the size of the
    grid times the number of the layer.
    """
    hits, places = layers[0]._hits(*sight.ends())
    if len(hits) == 0 and not any(len(layer._cells) for layer in layers):
        return
    size = layers[0].known.distance.size
    robots = np.repeat(np.arange(len(layers)), [len(layer._cells) for layer in layers])
    cells = np.concatenate([layer._cells for layer in layers]) + robots * size
    before = np.concatenate([layer._counts for layer in layers])
    means = np.concatenate([layer._places for layer in layers])
    counts = before - sight.through(means, robots)
    at = np.searchsorted(cells, hits)
    known = np.zeros(len(hits), dtype=np.bool_)
    if len(cells):
        known = cells[np.minimum(at, len(cells) - 1)] == hits
    old, new = at[known], ~known
    counts[old] = np.maximum(np.minimum(before[old] + 1, MOST), before[old])  # touched places exceed the limit
    means[old] += SHARE * (places[known] - means[old])
    for robot in set(robots[(before >= HITS) != (counts >= HITS)].tolist()):
        layers[robot].changes += 1
    cells = np.concatenate([cells, hits[new]])
    counts = np.concatenate([counts, np.ones(len(cells) - len(counts), dtype=np.int64)])
    means = np.concatenate([means, places[new]])
    order = np.argsort(cells, kind="stable")
    order = order[counts[order] > 0]
    cells, counts, means = cells[order], counts[order], means[order]
    bounds = np.searchsorted(cells, np.arange(len(layers) + 1) * size).tolist()
    for robot, (layer, first, last) in enumerate(zip(layers, bounds, bounds[1:], strict=False)):
        layer._cells = cells[first:last] - robot * size
        layer._counts, layer._places = counts[first:last], means[first:last]
