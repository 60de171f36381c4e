"""Global planning: what it costs to be somewhere, and what it costs to get from there to a goal.

The cost of a cell falls off exponentially with its distance from walls and obstacles, as in the inflation layer of
Nav2. Fast marching over it from the goal gives the cost-to-go of every cell at once, which
is the plan: whoever goes downhill arrives.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from skimage.graph import MCP_Geometric

from sim_nodes.geometry import Array
from sim_nodes.navigation.grid import Grid

INFLATION_RADIUS = 0.6  # [m]
INFLATION_SCALE = 5.0  # [1/m]
INFLATION_COST = 40.0  # beside an obstacle, in units of the cost of free floor
ESCAPE_RADIUS = 0.3  # [m] about the robot where floor too close to obstacles costs much instead of being closed
ESCAPE_COST = 100.0
SMOOTHING = 8  # cells of a path between two that its length is measured over
CLOSED = -1.0  # cells that are not entered, in the terms of skimage.graph


@dataclass(frozen=True)
class Plan:
    """The cost-to-go to a goal [m of free floor], infinite where there is no way; shape of the grid."""

    grid: Grid
    cost_to_go: Array
    goal: tuple[float, float]
    traversal: Array  # cost of each cell, of which the other follows

    def reaches(self, x: float, y: float) -> bool:
        """Whether there is a way from a point."""
        return bool(np.isfinite(self.cost_to_go[self.grid.cell(x, y)]))

    @cached_property
    def _tracer(self) -> MCP_Geometric:
        tracer = MCP_Geometric(self.traversal)
        tracer.find_costs([self.grid.cell(*self.goal)])
        return tracer

    def path(self, x: float, y: float) -> Array:
        """The cheapest way from a point to the goal, shape (n, 2) [m]; the point has to be one that `reaches`."""
        cells = self._tracer.traceback(self.grid.cell(x, y))
        return self.grid.points(np.array(cells[::-1]))

    def length(self, x: float, y: float) -> float:
        """Length of the cheapest way from a point to the goal [m], without the zigzag of its cells."""
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
    """Plan to a goal from everywhere.

    Args:
        grid: The grid of the map.
        distance: Distance of each cell to the next wall or obstacle [m].
        clearance: Distance that the base's origin has to keep [m].
        goal: Where to [m].
        robot: Where the robot is [m]; it is let out of places where it is closer to obstacles than it should be.
    """
    traversal = traversal_cost(grid, distance, clearance, robot)
    costs, _ = MCP_Geometric(traversal).find_costs([grid.cell(*goal)])
    return Plan(grid, costs * grid.resolution, goal, traversal)


def traversal_cost(grid: Grid, distance: Array, clearance: float, robot: tuple[float, float] | None) -> Array:
    """The cost of each cell; `CLOSED` where the robot must not be."""
    cost = 1.0 + INFLATION_COST * np.exp(-INFLATION_SCALE * (distance - clearance))
    cost[distance > INFLATION_RADIUS] = 1.0
    closed = distance < clearance
    cost[closed] = CLOSED
    if robot is not None:
        column, row = grid.cell(*robot)
        reach = math.ceil(ESCAPE_RADIUS / grid.resolution)
        near = (slice(max(column - reach, 0), column + reach + 1), slice(max(row - reach, 0), row + reach + 1))
        # A view: assigning to it changes the cost of the cells about the robot.
        about = cost[near]
        about[closed[near] & (distance[near] > 0.0)] = ESCAPE_COST
    return cost
