"""Shortcuts of paths over poses, where a direct connection is cheaper."""

from __future__ import annotations

import math

import numpy as np

from sim_nodes.geometry import Array, wrap
from sim_nodes.navigation.lattice import Floor, connect, relative
from sim_nodes.navigation.mobility import Mobility

WINDOW = 160  # poses ahead that a shortcut may lead to
STRIDE = 5  # poses between tried ends, and to the next start
TRIES = 5  # connections checked from a pose
SHORT = 2e-3  # [m] and [rad] of steps that are left out
LEAST_GAIN = 0.01  # [m] of costs
PASSES = 2


def shortened(path: Array, mobility: Mobility, floor: Floor) -> Array:
    """Return a path with cheaper connections in place of its pieces.

    Args:
        path: Poses (x, y, yaw), close to each other, shape (n, 3).
        mobility: Motions of the robot.
        floor: The floor.
    """
    for _ in range(PASSES):
        path = _once(path, mobility, floor)
    return _without_repeats(path, turns=mobility.lever > 0.0)


def _without_repeats(path: Array, *, turns: bool) -> Array:
    """Return a path without steps that are too short; turns in place are steps if the robot can turn so."""
    kept = [0]
    for index in range(1, len(path)):
        step = path[index] - path[kept[-1]]
        if math.hypot(step[0], step[1]) > SHORT or (turns and abs(wrap(step[2])) > SHORT):
            kept.append(index)
    if kept[-1] != len(path) - 1:
        kept[max(len(kept) - 1, 1) :] = [len(path) - 1]
    return path[kept]


def _once(path: Array, mobility: Mobility, floor: Floor) -> Array:
    costs = np.append(0.0, np.cumsum(mobility.step_costs(path) * floor.factors(path)[1:]))
    found, here = [path[:1]], 0
    while here < len(path) - 1:
        there, piece = _shortcut(path, costs, here, mobility, floor)
        found.append(piece)
        here = there
    return np.vstack(found)


def _shortcut(path: Array, costs: Array, here: int, mobility: Mobility, floor: Floor) -> tuple[int, Array]:
    """Return the end of the best shortcut from a pose and its poses; a close pose without one."""
    ends = np.arange(min(here + WINDOW, len(path) - 1), here + 1, -STRIDE)
    if len(ends):
        gains = costs[ends] - costs[here] - mobility.costs(relative(path[here], path[ends]))
        tried = ends[gains > LEAST_GAIN]
        for end in tried[:: max(1, len(tried) // TRIES)].tolist():
            piece = connect(mobility, path[here], path[end])
            cost = float((mobility.step_costs(np.vstack([path[here], piece])) * floor.factors(piece)).sum())
            if cost < costs[end] - costs[here] - LEAST_GAIN:
                return end, piece
    there = min(here + STRIDE, len(path) - 1)
    return there, path[here + 1 : there + 1]
