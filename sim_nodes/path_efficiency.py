"""Efficiency of driven paths: success weighted by path length."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from sim_nodes.geometry import Array, Pose2
from sim_nodes.metrics import EndedDrive
from sim_nodes.navigation.grid_search import CLOSED
from sim_nodes.navigation.maps import NavigationMap


def efficiency(drives: Sequence[EndedDrive], known: NavigationMap, radius: float) -> float | None:
    """Return the mean over drives of success * l / max(p, l), for shortest lengths l and driven lengths p.

    This is SPL of Anderson et al. 2018, On evaluation of embodied navigation agents. A drive of no length counts
    by its success.

    Args:
        drives: Ended drives.
        known: Map of the world, without spawned entities.
        radius: Radius of the robot [m].

    Returns:
        0 to 1; None without drives.
    """
    if not drives:
        return None
    return sum(_weighted(drive, known, radius) for drive in drives) / len(drives)


def _weighted(drive: EndedDrive, known: NavigationMap, radius: float) -> float:
    if not drive.succeeded:
        return 0.0
    stops = (drive.start, *drive.poses)
    shortest = sum(shortest_length(known, radius, start, end) for start, end in pairwise(stops))
    return shortest / max(drive.length, shortest) if shortest else 1.0


def shortest_length(known: NavigationMap, radius: float, start: Pose2, end: Pose2) -> float:
    """Return the length of a shortest path between two points [m], for a circle that keeps free of walls.

    A path through cells is pulled straight between its corners. Where no such path exists, as next to walls, it is
    the distance of the points.
    """
    from skimage.graph import MCP_Geometric  # noqa: PLC0415 - slow to load

    grid, free = known.grid, known.distance >= radius
    ends = [grid.cell(start.x, start.y), grid.cell(end.x, end.y)]
    straight = end.distance(start.x, start.y)
    if not all(free[cell] for cell in ends) or _is_free(free, *(np.array(cell) for cell in ends)):
        return straight
    search = MCP_Geometric(np.where(free, 1.0, CLOSED))
    search.find_costs([ends[0]], [ends[1]])
    try:
        cells = np.array(search.traceback(ends[1]))
    except ValueError:  # not connected
        return straight
    points = grid.points(cells[_corners(free, cells)])
    points[0], points[-1] = (start.x, start.y), (end.x, end.y)
    return float(np.hypot(*np.diff(points, axis=0).T).sum())


def _corners(free: NDArray[np.bool_], cells: Array) -> list[int]:
    """Return the indices of a path's cells between which straight lines are free, from its first to its last."""
    corners = [0]
    while corners[-1] < len(cells) - 1:
        here, far = corners[-1], corners[-1] + 1
        while far < len(cells) - 1 and _is_free(free, cells[here], cells[far + 1]):
            far += 1
        corners.append(far)
    return corners


def _is_free(free: NDArray[np.bool_], first: Array, last: Array) -> bool:
    """Whether all cells on a straight line between two cells are free."""
    count = int(np.abs(last - first).max()) + 1
    line = np.linspace(first, last, count).round().astype(int)
    return bool(free[line[:, 0], line[:, 1]].all())
