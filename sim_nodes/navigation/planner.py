"""The planner `grid`: the cheapest path over the cells of the map, made straight where that is safe.

The cost of a cell decreases exponentially with its distance from obstacles, as in Nav2's inflation layer.
The cheapest path over cells has corners of 45 degrees. Straight pieces replace them where they keep the clearance
and a margin, or come no closer to obstacles than that path. This margin, and the length over which costs decrease,
grow with the deviation of the localisation.
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from sim_nodes.geometry import Array, lengths_along, wrap
from sim_nodes.navigation.contracts import Path, Planner, PlanRequest, Setup, UnsuitableRobot
from sim_nodes.navigation.grid_search import CLOSED, Cell, Cells, GoalField, Window, cheapest_path
from sim_nodes.navigation.margins import further_margin, widened
from sim_nodes.navigation.smoothing import smooth
from sim_nodes.robots.navigation import NavigationDeclaration

ESCAPE_RADIUS = 0.3  # [m] around the robot where floor too close to obstacles is expensive instead of closed
ESCAPE_COST = 100.0
REACH = 3.0  # [m] around the robot that is searched before the whole map
MARGIN = 0.14  # [m] beyond the clearance that straight pieces keep where there is room


class GridPlanner(Planner):
    """The default planner."""

    DERIVED = ("_field",)

    def __init__(self, setup: Setup) -> None:
        setup.refuse_parameters("planner `grid`")
        radius = setup.declaration.drive.min_turning_radius
        if radius:
            raise UnsuitableRobot(f"`grid` ignores the turning radius of {radius:.2f} m; expected `hybrid`")
        self._known = setup.known
        self._clearance = setup.declaration.clearance
        self._parameters = setup.declaration.navigation
        self._slides = setup.declaration.drive.max_lateral_speed > 0.0
        self._field: tuple[float, GoalField] | None = None  # that of the last goal, for a margin

    def plan(self, request: PlanRequest) -> Path | None:
        """See `Planner.plan`."""
        grid, (start, goal) = request.grid, (request.start, request.goal)
        first, last = grid.cell(start.x, start.y), grid.cell(goal.x, goal.y)
        if self._known.distance[last] < self._clearance:
            return None

        margin = further_margin(request.deviation)
        parameters = widened(self._parameters, margin)

        def cost_in(window: Window) -> Array:
            cost = traversal_cost(request.distance[window], self._clearance, parameters)
            within = (first[0] - window[0].start, first[1] - window[1].start)
            open_around(cost, request.distance[window], within, grid.resolution)
            return cost

        reach = round(REACH / grid.resolution)
        cells = cheapest_path(
            self._field_of(last, margin), first, reach, cost_in, partial(self._is_affected, request)
        )
        if cells is None:
            return None
        points = grid.points(cells)
        points[0], points[-1] = start[:2], goal[:2]
        # The path away from a close obstacle stays as it is: a straight piece may be as close as its ends.
        away = int((grid.interpolate(request.distance, *points.T) >= self._clearance).argmax())
        rest = smooth(grid, request.distance, points[away:], self._clearance + MARGIN + margin)
        path = np.vstack([points[:away], rest])
        return Path(path, turned_along(path, start.yaw, goal.yaw) if self._slides else None)

    def _field_of(self, goal: Cell, margin: float) -> GoalField:
        if self._field is None or self._field[0] != margin or self._field[1].goal != goal:
            cost = traversal_cost(self._known.distance, self._clearance, widened(self._parameters, margin))
            self._field = margin, GoalField(cost, goal)
        return self._field[1]

    def _is_affected(self, request: PlanRequest, cells: Cells) -> bool:
        """Whether obstacles that are not on the map change the cost of cells."""
        where = tuple(cells.T)
        room = request.distance[where]
        reach = max(self._parameters.inflation_radius, self._clearance)
        return bool(((room < self._known.distance[where]) & (room <= reach)).any())


def turned_along(points: Array, start: float, end: float) -> Array:
    """Return headings that turn evenly from one to another along a path [rad], shape (n,)."""
    lengths = lengths_along(points)
    headings: Array = start + wrap(end - start) * lengths / max(float(lengths[-1]), 1e-9)
    headings[-1] = end
    return headings


def inflation(gaps: Array, parameters: NavigationDeclaration) -> Array:
    """Return the relative costs of floor by the gap to obstacles [m], as in Nav2's inflation layer."""
    p = parameters
    return 1.0 + p.inflation_cost * np.exp(-p.cost_scaling_factor * np.maximum(gaps, 0.0))


def traversal_cost(distance: Array, clearance: float, parameters: NavigationDeclaration) -> Array:
    """Return the cost of cells; `CLOSED` for closed ones.

    Args:
        distance: Distance of each cell to the nearest wall or obstacle [m].
        clearance: Minimum distance of the base's origin [m].
        parameters: Cost near obstacles.
    """
    cost = inflation(distance - clearance, parameters)
    cost[distance > parameters.inflation_radius] = 1.0
    cost[distance < clearance] = CLOSED
    return cost


def open_around(cost: Array, distance: Array, robot: Cell, resolution: float) -> None:
    """Open closed cells around a robot at a cost, so that it may leave places that are too close to obstacles.

    Args:
        cost: Cost of each cell, which is changed.
        distance: Distance of each cell to the nearest wall or obstacle [m].
        robot: The cell of the robot.
        resolution: Size of cells [m].
    """
    column, row = robot
    reach = math.ceil(ESCAPE_RADIUS / resolution)
    near = (slice(max(column - reach, 0), column + reach + 1), slice(max(row - reach, 0), row + reach + 1))
    about = cost[near]  # a view
    about[(about == CLOSED) & (distance[near] > 0.0)] = ESCAPE_COST
    cost[column, row] = max(cost[column, row], 1.0)
