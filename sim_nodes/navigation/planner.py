"""The planner `grid`: the cheapest path over the cells of the map, made straight where that is safe.

The cost of a cell decreases exponentially with its distance from obstacles, as in Nav2's inflation layer.
The cheapest path over cells has corners of 45 degrees. Straight pieces replace them where they keep the clearance
and a margin, or come no closer to obstacles than that path.
"""

from __future__ import annotations

import math

import numpy as np

from sim_nodes.geometry import Array
from sim_nodes.navigation.contracts import Path, Planner, PlanRequest, Setup
from sim_nodes.navigation.maps import Grid
from sim_nodes.robots.navigation import NavigationDeclaration

ESCAPE_RADIUS = 0.3  # [m] around the robot where floor too close to obstacles is expensive instead of closed
ESCAPE_COST = 100.0
CLOSED = -1.0  # cost of closed cells for skimage.graph
SPACING = 0.05  # [m] between points of a path
MARGIN = 0.14  # [m] beyond the clearance that straight pieces keep where there is room
PASSES, ROUNDS = 2, 8  # of smoothing


class GridPlanner(Planner):
    """The default planner."""

    def __init__(self, setup: Setup) -> None:
        setup.refuse_parameters("planner `grid`")
        self._clearance = setup.declaration.clearance
        self._parameters = setup.declaration.navigation

    def plan(self, request: PlanRequest) -> Path | None:
        """See `Planner.plan`."""
        from skimage.graph import MCP_Geometric  # noqa: PLC0415 - slow to load

        grid, (start, goal) = request.grid, (request.start, request.goal)
        robot = (start.x, start.y)
        cost = traversal_cost(grid, request.distance, self._clearance, self._parameters, robot)
        first, last = grid.cell(*robot), grid.cell(goal.x, goal.y)
        if cost[first] == CLOSED or cost[last] == CLOSED:
            return None
        search = MCP_Geometric(cost)
        costs, _ = search.find_costs([first], [last])
        if not math.isfinite(costs[last]):
            return None
        points = grid.points(np.array(search.traceback(last)))
        points[0], points[-1] = robot, (goal.x, goal.y)
        # The path away from a close obstacle stays as it is: a straight piece may be as close as its ends.
        away = int((grid.interpolate(request.distance, *points.T) >= self._clearance).argmax())
        rest = smooth(grid, request.distance, points[away:], self._clearance + MARGIN)
        return Path(np.vstack([points[:away], rest]))


def traversal_cost(
    grid: Grid, distance: Array, clearance: float, parameters: NavigationDeclaration, robot: tuple[float, float]
) -> Array:
    """Return the cost of each cell; `CLOSED` for closed ones.

    Args:
        grid: Grid of the map.
        distance: Distance of each cell to the nearest wall or obstacle [m].
        clearance: Minimum distance of the base's origin [m].
        parameters: Cost near obstacles.
        robot: Position of the robot [m]; it may leave places that are too close to obstacles.
    """
    p = parameters
    cost = 1.0 + p.inflation_cost * np.exp(-p.cost_scaling_factor * np.maximum(distance - clearance, 0.0))
    cost[distance > p.inflation_radius] = 1.0
    closed = distance < clearance
    cost[closed] = CLOSED
    column, row = grid.cell(*robot)
    reach = math.ceil(ESCAPE_RADIUS / grid.resolution)
    near = (slice(max(column - reach, 0), column + reach + 1), slice(max(row - reach, 0), row + reach + 1))
    # A view: assigning to it changes the cost of cells around the robot.
    about = cost[near]
    about[closed[near] & (distance[near] > 0.0)] = ESCAPE_COST
    cost[column, row] = max(cost[column, row], 1.0)
    return cost


def smooth(grid: Grid, distance: Array, points: Array, comfort: float) -> Array:
    """Return a path with straight pieces where they are safe, and with even spacing.

    Args:
        grid: Grid of the map.
        distance: Distance of each cell to the nearest wall or obstacle [m].
        points: Path over cells, shape (n, 2) [m].
        comfort: Distance that a piece may always have [m]; other pieces keep that of the path.
    """
    for _ in range(PASSES):
        room = grid.interpolate(distance, *points.T)
        corners, here = [0], 0
        while here < len(points) - 1:
            here = _farthest_in_sight(grid, distance, points, room, comfort, here)
            corners.append(here)
        points = _relaxed(grid, distance, _resampled(points[corners]), comfort)
    return points


def _farthest_in_sight(grid: Grid, distance: Array, points: Array, room: Array, comfort: float, here: int) -> int:
    """Return the farthest point that a safe straight piece from `here` reaches."""
    best, step = here + 1, 2
    while step >= 1 and best < len(points) - 1:
        tried = min(best + step, len(points) - 1)
        needed = min(comfort, float(room[here : tried + 1].min()) - 1e-6)
        if _least_room(grid, distance, points[here], points[tried]) >= needed:
            best, step = tried, 2 * step
        else:
            step //= 2
    return best


def _least_room(grid: Grid, distance: Array, start: Array, end: Array) -> float:
    """Return the least distance to obstacles on a straight piece [m]."""
    (ax, ay), (bx, by) = start.tolist(), end.tolist()
    count = max(2, math.ceil(math.hypot(bx - ax, by - ay) / grid.resolution) + 1)
    along = np.arange(count) / (count - 1.0)
    return float(grid.interpolate(distance, ax + along * (bx - ax), ay + along * (by - ay)).min())


def _resampled(corners: Array) -> Array:
    """Return points on a polyline with a spacing of at most `SPACING`."""
    lengths = np.append(0.0, np.cumsum(np.hypot(*np.diff(corners, axis=0).T)))
    count = max(2, math.ceil(lengths[-1] / SPACING) + 1)
    along = np.linspace(0.0, lengths[-1], count)
    return np.column_stack([np.interp(along, lengths, corners[:, axis]) for axis in (0, 1)])


def _relaxed(grid: Grid, distance: Array, path: Array, comfort: float) -> Array:
    """Return a path with round corners: inner points move between their neighbours, unless that is too close."""
    path, room = path.copy(), grid.interpolate(distance, *path.T)[1:-1]
    for _ in range(ROUNDS):
        inner = path[1:-1]
        moved = 0.5 * inner + 0.25 * (path[:-2] + path[2:])
        after = grid.interpolate(distance, *moved.T)
        allowed = after >= np.minimum(comfort, room)
        path[1:-1] = np.where(allowed[:, None], moved, inner)
        room = np.where(allowed, after, room)
    return path
