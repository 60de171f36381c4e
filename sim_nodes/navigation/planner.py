"""Global planning: cost of each cell, and cost-to-go to a goal.

The cost of a cell decreases exponentially with its distance from walls and obstacles, as in Nav2's inflation
layer. Fast marching from the goal gives the cost-to-go of every cell, which is the plan: the robot follows its
gradient.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from skimage.graph import MCP_Geometric

from sim_nodes.geometry import Array
from sim_nodes.navigation.maps import Grid

INFLATION_RADIUS = 0.6  # [m]
INFLATION_SCALE = 5.0  # [1/m]
INFLATION_COST = 40.0  # next to an obstacle, relative to free floor
ESCAPE_RADIUS = 0.3  # [m] around the robot where floor too close to obstacles is expensive instead of closed
ESCAPE_COST = 100.0
SMOOTHING = 8  # cells between the points that measure the length of a path
CLOSED = -1.0  # cost of closed cells for skimage.graph


@dataclass(frozen=True)
class Plan:
    """Cost-to-go to a goal [m of free floor], infinite for unreachable cells; has the shape of the grid."""

    grid: Grid
    cost_to_go: Array
    goal: tuple[float, float]
    traversal: Array  # cost of each cell

    def reaches(self, x: float, y: float) -> bool:
        """Whether the goal is reachable from a point."""
        return bool(np.isfinite(self.cost_to_go[self.grid.cell(x, y)]))

    @cached_property
    def _tracer(self) -> MCP_Geometric:
        tracer = MCP_Geometric(self.traversal)
        tracer.find_costs([self.grid.cell(*self.goal)])
        return tracer

    def path(self, x: float, y: float) -> Array:
        """Return the cheapest path from a reachable point to the goal, shape (n, 2) [m]."""
        cells = self._tracer.traceback(self.grid.cell(x, y))
        return self.grid.points(np.array(cells[::-1]))

    def length(self, x: float, y: float) -> float:
        """Return the length of the cheapest path from a point to the goal [m], without the zigzag of cells."""
        path = self.path(x, y)
        coarse = np.vstack([path[:-1:SMOOTHING], path[-1:], self.goal])
        return float(np.hypot(*np.diff(coarse, axis=0).T).sum())


def plan_to(
    grid: Grid,
    distance: Array,
    clearance: float,
    goal: tuple[float, float],
    robot: tuple[float, float] | None = None,
) -> Plan:
    """Plan to a goal from all cells.

    Args:
        grid: Grid of the map.
        distance: Distance of each cell to the nearest wall or obstacle [m].
        clearance: Minimum distance of the base's origin [m].
        goal: Goal [m].
        robot: Position of the robot [m]; it may leave places that are too close to obstacles.
    """
    traversal = traversal_cost(grid, distance, clearance, robot)
    costs, _ = MCP_Geometric(traversal).find_costs([grid.cell(*goal)])
    return Plan(grid, costs * grid.resolution, goal, traversal)


def traversal_cost(grid: Grid, distance: Array, clearance: float, robot: tuple[float, float] | None) -> Array:
    """Return the cost of each cell; `CLOSED` for closed ones."""
    cost = 1.0 + INFLATION_COST * np.exp(-INFLATION_SCALE * (distance - clearance))
    cost[distance > INFLATION_RADIUS] = 1.0
    closed = distance < clearance
    cost[closed] = CLOSED
    if robot is not None:
        column, row = grid.cell(*robot)
        reach = math.ceil(ESCAPE_RADIUS / grid.resolution)
        near = (slice(max(column - reach, 0), column + reach + 1), slice(max(row - reach, 0), row + reach + 1))
        # A view: assigning to it changes the cost of cells around the robot.
        about = cost[near]
        about[closed[near] & (distance[near] > 0.0)] = ESCAPE_COST
    return cost
