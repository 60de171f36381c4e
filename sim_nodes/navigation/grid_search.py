"""Cheapest paths over the cells of a map, by a field of costs to the goal that knows no obstacles.

Obstacles only add cost, so the field is a lower bound. A robot that has left a window around it needs at least the
cost of the field from there. So the cheapest way out of the window, continued on the field, is the cheapest path,
unless obstacles lie on that continuation; then the whole map is searched. The bound is used as in A* (Hart,
Nilsson, Raphael 1968).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sim_nodes.geometry import Array
from sim_nodes.memory import return_free

Cell = tuple[int, int]
Cells = NDArray[np.int64]
"""Indices of cells, shape (n, 2)."""
Window = tuple[slice, slice]

CLOSED = -1.0  # cost of closed cells for skimage.graph


def connected_cells(free: NDArray[np.bool_], cell: Cell) -> NDArray[np.bool_]:
    """Return which free cells are connected with one of them, also diagonally; none if it is not free.

    Args:
        free: Whether each cell is free, shape (columns, rows).
        cell: The cell.
    """
    if not free[cell]:
        return np.zeros_like(free)
    # `label` of scipy is faster, but its package takes a node 28 MiB and 0.2 s to load.
    from skimage.graph import MCP  # noqa: PLC0415 - slow to load

    costs, _ = MCP(np.where(free, 1.0, CLOSED)).find_costs([cell])
    connected: NDArray[np.bool_] = np.isfinite(costs)
    return connected


class GoalField:
    """The costs from all cells of a map to a goal.

    Args:
        cost: Cost of each cell, shape (columns, rows).
        goal: The goal.
    """

    def __init__(self, cost: Array, goal: Cell) -> None:
        from skimage.graph import MCP_Geometric  # noqa: PLC0415 - slow to load

        self.goal = goal
        search = MCP_Geometric(cost)
        self.costs: Array
        self.costs, steps = search.find_costs([goal])
        self._trace = _Trace(steps, np.asarray(search.offsets))
        del search, steps
        return_free()  # once for each goal

    def way_from(self, cell: Cell) -> Cells:
        """Return the cheapest path from a cell of finite cost to the goal."""
        return self._trace.back(cell, self.goal)


class _Trace:
    """The last steps to the cells of a search. The `traceback` of the search itself takes several times as long.

    Args:
        steps: Number of the step to each cell.
        offsets: The steps, shape (steps, 2).
    """

    def __init__(self, steps: NDArray[np.integer[Any]], offsets: NDArray[np.integer[Any]]) -> None:
        self._steps, self._offsets = steps, offsets.tolist()

    def back(self, cell: Cell, start: Cell) -> Cells:
        """Return the path from a cell back to the start of the search."""
        column, row = cell
        path = [cell]
        while (column, row) != start:
            along, across = self._offsets[self._steps.item(column, row)]
            column, row = column - along, row - across
            path.append((column, row))
        return np.array(path)


def cheapest_path(
    field: GoalField,
    start: Cell,
    reach: int,
    cost_in: Callable[[Window], Array],
    is_affected: Callable[[Cells], bool],
) -> Cells | None:
    """Return the cheapest path from a cell to the goal of a field; None without one.

    Args:
        field: Field of costs without obstacles.
        start: The first cell.
        reach: Cells from the start to the border of the window that is tried before the whole map.
        cost_in: Returns the costs of the cells in a window.
        is_affected: Returns whether obstacles change the cost of a path.
    """
    if math.isfinite(field.costs[start]):
        way = field.way_from(start)
        if not is_affected(way):
            return way
    window = _window(field.costs.shape, start, reach)
    path, is_cheapest = _path_through(field, start, window, cost_in(window), is_affected)
    if not is_cheapest:
        window = (slice(0, field.costs.shape[0]), slice(0, field.costs.shape[1]))
        path, _ = _path_through(field, start, window, cost_in(window), is_affected)
    return path


def _window(shape: tuple[int, ...], centre: Cell, reach: int) -> Window:
    """Return the cells of a map about one of them."""
    columns, rows = (
        slice(max(at - reach, 0), min(at + reach + 1, size)) for at, size in zip(centre, shape, strict=True)
    )
    return columns, rows


def _path_through(
    field: GoalField, start: Cell, window: Window, cost: Array, is_affected: Callable[[Cells], bool]
) -> tuple[Cells | None, bool]:
    """Return the cheapest path through a window, if any, and whether that is the cheapest of all."""
    from skimage.graph import MCP_Geometric  # noqa: PLC0415 - slow to load

    corner = np.array([side.start for side in window])
    goal = field.goal - corner
    exits = _exits(field.costs.shape, window)
    ends = None if len(exits) else [tuple(goal.tolist())]
    if ((goal >= 0) & (goal < cost.shape)).all():
        exits = np.vstack([exits, goal])
    search = MCP_Geometric(cost)
    first: Cell = tuple((start - corner).tolist())
    costs, steps = search.find_costs([first], ends)
    totals = costs[tuple(exits.T)] + field.costs[window][tuple(exits.T)]
    best = int(totals.argmin())
    if not math.isfinite(totals[best]):
        return None, True
    path = _Trace(steps, np.asarray(search.offsets)).back(tuple(exits[best].tolist()), first)[::-1] + corner
    onwards = field.way_from(tuple(path[-1].tolist()))
    return np.vstack([path, onwards[1:]]), len(onwards) == 1 or not is_affected(onwards)


def _exits(shape: tuple[int, ...], window: Window) -> Cells:
    """Return the cells of a window, relative to it, that have neighbours outside of it on the map."""
    columns, rows = (side.stop - side.start for side in window)
    border = np.zeros((columns, rows), dtype=np.bool_)
    border[0] |= window[0].start > 0
    border[-1] |= window[0].stop < shape[0]
    border[:, 0] |= window[1].start > 0
    border[:, -1] |= window[1].stop < shape[1]
    return np.argwhere(border)
