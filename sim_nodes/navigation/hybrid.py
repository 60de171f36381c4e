"""The planner `hybrid`: paths with headings, for cars and for robots that are not round.

It finds a path over poses (`lattice.py`), so that the outline fits everywhere and cars steer within their limits.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from sim_nodes.navigation.contracts import InvalidParameter, Path, Planner, PlanRequest, Setup
from sim_nodes.navigation.cover import cover_of
from sim_nodes.navigation.grid_search import CLOSED
from sim_nodes.navigation.lattice import Floor, Search
from sim_nodes.navigation.margins import further_margin, widened
from sim_nodes.navigation.mobility import mobility_of
from sim_nodes.navigation.planner import open_around, traversal_cost
from sim_nodes.navigation.shortcuts import shortened

DEFAULTS = {"minimum_turning_radius": 0.0, "reverse_penalty": 2.1, "change_penalty": 0.3}
SPARE = 1.1  # factor of the smallest turning radius, so that the controller can correct errors
COMFORT = 0.04  # [m] gap to obstacles, beyond the margin, of paths where there is room
FEW_POSES, MOST_POSES = 15_000, 100_000  # of a search with that gap, and without


class HybridPlanner(Planner):
    """The default planner of cars, and of robots whose outline is not round.

    It has parameters by the names of Nav2's Smac planner. `minimum_turning_radius` [m] is that of cars.
    `reverse_penalty` is the cost of driving backwards relative to forwards.
    `change_penalty` is the cost of a change of direction [m].
    """

    def __init__(self, setup: Setup) -> None:
        parameters = _parameters(setup)
        declared = setup.declaration
        radius = max(parameters["minimum_turning_radius"], SPARE * declared.drive.min_turning_radius)
        self._change_penalty = parameters["change_penalty"]
        self._mobility = mobility_of(declared.drive, radius, parameters["reverse_penalty"])
        self._cover = cover_of(declared)
        self._navigation = declared.navigation

    def plan(self, request: PlanRequest) -> Path | None:
        """See `Planner.plan`."""
        from skimage.graph import MCP_Geometric  # noqa: PLC0415 - slow to load

        grid, distance, cover = request.grid, request.distance, self._cover
        start, goal = np.array(request.start), np.array(request.goal)
        margin = further_margin(request.deviation)
        navigation = widened(self._navigation, margin)
        start_gap, goal_gap = cover.gaps(grid, distance, np.array((start, goal))).tolist()
        tight = Floor(grid, distance, cover, navigation, start, goal, start_gap, goal_gap, 0.0)
        if goal_gap < 0.0:
            return None
        (first,), (last,) = (cover.cores(pose[None]).tolist() for pose in (start, goal))
        cost = traversal_cost(distance, cover.room, navigation)
        open_around(cost, distance, grid.cell(*first), grid.resolution)
        if cost[grid.cell(*last)] == CLOSED:
            return None
        to_go, _ = MCP_Geometric(cost).find_costs([grid.cell(*last)])
        to_go *= grid.resolution
        for floor, most_poses in ((replace(tight, spare=COMFORT + margin), FEW_POSES), (tight, MOST_POSES)):
            found = Search(self._mobility, floor, to_go, self._change_penalty, most_poses).run(start, goal)
            if found is not None:
                poses = shortened(found, self._mobility, floor)
                return Path(poses[:, :2].copy(), poses[:, 2].copy())
        return None


def _parameters(setup: Setup) -> dict[str, float]:
    unknown = setup.parameters.keys() - DEFAULTS
    if unknown:
        raise InvalidParameter(
            f"unknown parameter `{min(unknown)}`; expected one of {', '.join(sorted(DEFAULTS))}"
        )
    found = dict(DEFAULTS)
    for name, value in setup.parameters.items():
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 <= value <= 1000.0:
            raise InvalidParameter(f"invalid `{name}` {value!r}; expected a number from 0 to 1000")
        found[name] = float(value)
    if found["reverse_penalty"] < 1.0:
        raise InvalidParameter(f"invalid `reverse_penalty` {found['reverse_penalty']:g}; expected 1 or more")
    return found
