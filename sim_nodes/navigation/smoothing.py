"""Paths over cells, made straight where that is safe, with round corners.

Corners are dropped where the straight piece between their neighbours keeps a comfortable distance, or comes no
closer to obstacles than the path. Every other corner is tested at once, so the number of tests is that of
halvings of the path.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from sim_nodes.geometry import Array, Indices, lengths_along
from sim_nodes.navigation.maps import Grid

SPACING = 0.05  # [m] between points of a path
ROUNDS = (3, 8)  # of relaxation, in each pass
NODES = 24
COARSE = 4
CLOSER = 1e-6  # [m] that a straight piece may be closer to obstacles than the path, by rounding

AreSafe = Callable[[Indices, Indices], NDArray[np.bool_]]
"""Returns whether straight pieces are safe, by the indices of their ends."""


def smooth(grid: Grid, distance: Array, points: Array, comfort: float) -> Array:
    """Return a path with straight pieces where they are safe, and with even spacing.

    Args:
        grid: Grid of the map.
        distance: Distance of each cell to the nearest wall or obstacle [m].
        points: Path over cells, shape (n, 2) [m].
        comfort: Distance that a piece may always have [m]; other pieces keep that of the path.
    """
    for rounds in ROUNDS:
        corners = _straightened(grid, distance, points, comfort)
        points = _relaxed(grid, distance, _resampled(corners), comfort, rounds)
    return points


def _straightened(grid: Grid, distance: Array, points: Array, comfort: float) -> Array:
    """Return the shortest polyline of safe straight pieces between points of a path, and of the path itself."""
    needed = np.minimum(comfort, grid.interpolate(distance, *points.T) - CLOSER)
    nodes = np.linspace(0, len(points) - 1, min(NODES, len(points))).astype(np.int64)
    starts, ends = _pairs(len(nodes))
    safe = np.zeros((len(nodes), len(nodes)), dtype=np.bool_)
    safe[starts, ends] = _are_safe(grid, distance, points, needed, nodes[starts], nodes[ends])
    places = points[nodes]
    away = places[:, None] - places
    lengths = np.where(safe, np.sqrt(away[..., 0] ** 2 + away[..., 1] ** 2), np.inf)
    before = _shortest(lengths, lengths_along(points)[nodes])
    return _joined(points, nodes, before, safe)


@lru_cache(maxsize=NODES)
def _pairs(count: int) -> tuple[Indices, Indices]:
    """Return the numbers of all pairs of nodes, the earlier and the later ones."""
    starts, ends = np.triu_indices(count, 1)
    return starts, ends


def _shortest(lengths: Array, along: Array) -> list[int]:
    """Return the node before each one on the shortest polyline, which may follow the path between neighbours.

    Args:
        lengths: Lengths of straight pieces from node to later node, infinite for unsafe ones, shape (n, n).
        along: Lengths of the path up to each node, shape (n,).
    """
    # Numbers of Python, because arrays of this size take longer.
    to, path = lengths.T.tolist(), along.tolist()
    before, best = [-1], [0.0]
    for node in range(1, len(path)):
        length, nearest = min([best[last] + to[node][last], last] for last in range(node))
        follow = best[node - 1] + (path[node] - path[node - 1])
        best.append(min(length, follow))
        before.append(nearest if length <= follow else node - 1)
    return before


def _joined(points: Array, nodes: Indices, before: list[int], safe: NDArray[np.bool_]) -> Array:
    pieces, node = [points[-1:]], len(nodes) - 1
    while node > 0:
        last = before[node]
        first = nodes[last]
        pieces.append(points[first : first + 1] if safe[last, node] else points[first : nodes[node]])
        node = last
    return np.concatenate(pieces[::-1])


def _are_safe(
    grid: Grid, distance: Array, points: Array, needed: Array, starts: Indices, ends: Indices
) -> NDArray[np.bool_]:
    """Return whether straight pieces between points keep the distance that the path needs there."""
    bounds = np.column_stack([starts, ends + 1]).ravel()
    least = np.minimum.reduceat(np.append(needed, np.inf), bounds)[::2]
    safe = np.ones(len(starts), dtype=np.bool_)
    for spacing in (COARSE * grid.resolution, grid.resolution):  # most pieces are unsafe at few points already
        left = np.flatnonzero(safe)
        room = _least_room(grid, distance, points[starts[left]], points[ends[left]], spacing)
        safe[left] = room >= least[left]
    return safe


def _least_room(grid: Grid, distance: Array, starts: Array, ends: Array, spacing: float) -> Array:
    """Return the least distance to obstacles at points of straight pieces, one for each piece [m]."""
    ways = ends - starts
    lengths = np.sqrt(ways[:, 0] ** 2 + ways[:, 1] ** 2)
    counts = np.maximum(np.ceil(lengths / spacing).astype(np.int64) + 1, 2)
    firsts = np.cumsum(counts) - counts
    numbers = np.arange(int(counts.sum())) - np.repeat(firsts, counts)
    steps = ways / (counts[:, None] - 1.0)
    x, y = (np.repeat(starts[:, k], counts) + numbers * np.repeat(steps[:, k], counts) for k in (0, 1))
    least: Array = np.minimum.reduceat(grid.interpolate(distance, x, y), firsts)
    return least


def _resampled(corners: Array) -> Array:
    """Return points on a polyline with a spacing of at most `SPACING`."""
    lengths = lengths_along(corners)
    count = max(2, math.ceil(lengths[-1] / SPACING) + 1)
    along = np.linspace(0.0, lengths[-1], count)
    return np.column_stack([np.interp(along, lengths, corners[:, axis]) for axis in (0, 1)])


def _relaxed(grid: Grid, distance: Array, path: Array, comfort: float, rounds: int) -> Array:
    """Return a path with round corners: inner points move between their neighbours, unless that is too close."""
    path, room = path.copy(), grid.interpolate(distance, *path.T)[1:-1]
    for _ in range(rounds):
        inner = path[1:-1]
        moved = 0.5 * inner + 0.25 * (path[:-2] + path[2:])
        after = grid.interpolate(distance, *moved.T)
        allowed = after >= np.minimum(comfort, room)
        path[1:-1] = np.where(allowed[:, None], moved, inner)
        room = np.where(allowed, after, room)
    return path
