from __future__ import annotations

import math

import numpy as np
import pytest

from sim_nodes.check.bench import BASE
from sim_nodes.geometry import Array, Pose2
from sim_nodes.navigation import grid_search
from sim_nodes.navigation.contracts import PlanRequest, Setup
from sim_nodes.navigation.grid_search import Cells, GoalField, Window, cheapest_path
from sim_nodes.navigation.maps import NavigationMap, build_map
from sim_nodes.navigation.obstacles import ObstacleLayer
from sim_nodes.navigation.planner import REACH, GridPlanner
from sim_nodes.noise import Noise
from sim_nodes.worlds.loader import load_world

SIZE = (60, 50)
START, GOAL = (12, 20), (55, 40)


def cost_of(path: Cells, cost: Array) -> float:
    steps = np.hypot(*np.diff(path, axis=0).T)
    assert steps.max() < 1.5
    along = cost[tuple(path.T)]
    assert (along > 0.0).all()
    return float(((along[1:] + along[:-1]) / 2 * steps).sum())


def search(before: Array, now: Array, reach: int) -> Cells | None:
    def cost_in(window: Window) -> Array:
        return now[window]

    def is_affected(cells: Cells) -> bool:
        return bool((now[tuple(cells.T)] != before[tuple(cells.T)]).any())

    return cheapest_path(GoalField(before, GOAL), START, reach, cost_in, is_affected)


@pytest.mark.parametrize("seed", range(12))
def test_a_search_in_a_window_finds_the_cheapest_path_of_all(seed: int) -> None:
    random = np.random.default_rng(seed)
    before = random.uniform(1.0, 3.0, SIZE)
    now = before.copy()
    for column, row in random.integers(0, 45, (10, 2)):
        now[column : column + 9, row : row + 9] = random.choice([-1.0, 8.0])
    now[START] = 1.0
    found, full = search(before, now, 8), search(before, now, max(SIZE))
    assert (found is None) == (full is None)
    if found is not None and full is not None:
        assert tuple(found[0]) == START and tuple(found[-1]) == GOAL
        assert cost_of(found, now) == pytest.approx(cost_of(full, now))


def test_a_start_surrounded_by_obstacles_has_no_path() -> None:
    before = np.ones(SIZE)
    now = before.copy()
    now[START[0] - 3 : START[0] + 4, START[1] - 3 : START[1] + 4] = -1.0
    now[START] = 1.0
    assert search(before, now, 8) is None


def planner_of(known: NavigationMap) -> GridPlanner:
    return GridPlanner(Setup(BASE, known, {}, Noise(0, "test")))


def test_plans_for_one_goal_share_the_search_from_it(monkeypatch: pytest.MonkeyPatch) -> None:
    world = load_world("maze")
    known = build_map(world.extent, world.walls, world.outlines)
    blocked = known.distance.copy()
    obstacle = known.grid.cell(0.8, 0.2)
    xs, ys = known.grid.centres()
    x, y = known.grid.points(np.array([obstacle]))[0]
    blocked = np.minimum(blocked, np.hypot(xs - x, ys - y))
    fields, searched = [0], list[int]()
    made, through = GoalField.__init__, grid_search._path_through

    def counted(field: GoalField, cost: Array, goal: tuple[int, int]) -> None:
        fields[0] += 1
        made(field, cost, goal)

    def recorded(*args: object) -> object:
        searched.append(args[3].size)  # type: ignore[attr-defined]
        return through(*args)  # type: ignore[arg-type]

    monkeypatch.setattr(GoalField, "__init__", counted)
    monkeypatch.setattr(grid_search, "_path_through", recorded)
    planner = planner_of(known)
    for x in (0.0, 0.1, 0.2):
        for distance in (known.distance, blocked):
            assert planner.plan(PlanRequest(known.grid, distance, Pose2(x, 0.0, 0.0), Pose2(3.0, -3.0, 0.0), 0))
    assert fields == [1]
    window = (2 * round(REACH / known.grid.resolution) + 1) ** 2
    assert len(searched) <= 3  # none without obstacles
    assert sum(searched) <= 3 * window < 3 * known.distance.size


def test_distances_to_obstacles_are_computed_around_them() -> None:
    known = build_map((-3.0, -3.0, 3.0, 3.0), ())
    layer = ObstacleLayer(known)
    layer._cells = np.array(
        [np.ravel_multi_index(known.grid.cell(x, 0.51), known.distance.shape) for x in (0.02, 2.98)]
    )
    layer._counts, layer._places = np.array([5, 5]), np.array([[0.02, 0.51], [2.98, 0.51]])
    distance = layer.distance(0.6)
    grid = known.grid
    assert distance[grid.cell(0.52, 0.52)] == pytest.approx(math.hypot(0.505, 0.015) - 0.035, abs=1e-6)
    assert distance[grid.cell(0.02, -0.42)] == known.distance[grid.cell(0.02, -0.42)]
    assert distance[grid.cell(2.52, 0.52)] < 0.46
