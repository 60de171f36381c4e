"""Unsure robots keep farther away from walls; touched places are remembered."""

from __future__ import annotations

import math

import numpy as np
import pytest

from sim_nodes.check.bench import BASE
from sim_nodes.geometry import Array, Pose2, lengths_along
from sim_nodes.navigation.contracts import ControlInput, Path, PlanRequest
from sim_nodes.navigation.goals import Goal
from sim_nodes.navigation.maps import NavigationMap, build_map
from sim_nodes.navigation.margins import further_margin
from sim_nodes.navigation.navigator import Navigator
from sim_nodes.navigation.obstacles import MOST, TOUCHED, ObstacleLayer
from sim_nodes.navigation.planner import GridPlanner
from sim_nodes.noise import Noise
from sim_nodes.physics import Wall
from sim_nodes.robots.footprint import Footprint
from sim_nodes.robots.kinematics import AT_REST
from tests.sim_nodes.plans import setup_for
from tests.sim_nodes.test_navigation import EXTENT, HERE, NOTHING, open_floor, thing_ahead
from tests.sim_nodes.test_recovery import HERE as STANDING
from tests.sim_nodes.test_recovery import moved

CORNER = build_map(EXTENT, (Wall("w", 0.0, -1.5, math.pi / 2, 3.0, 0.1, 0.5),))
DOOR = build_map(
    EXTENT,
    (Wall("low", 0.0, -1.75, math.pi / 2, 3.0, 0.1, 0.5), Wall("high", 0.0, 1.75, math.pi / 2, 3.0, 0.1, 0.5)),
)


def planned(known: NavigationMap, deviation: float) -> Path:
    start, goal = Pose2(-1.0, -1.0, 0.0), Pose2(1.0, -1.0, 0.0)
    request = PlanRequest(known.grid, known.distance, start, goal, 0, deviation)
    path = GridPlanner(setup_for(known)).plan(request)
    assert path is not None
    return path


def room_along(known: NavigationMap, points: Array) -> float:
    return float(known.grid.interpolate(known.distance, *points.T).min())


def test_usual_deviations_add_no_margin_and_large_ones_a_limited_one() -> None:
    assert [further_margin(deviation) for deviation in (0.0, 0.05, 0.1, 0.14)] == [0.0] * 4
    assert further_margin(0.2) == pytest.approx(0.1)
    assert further_margin(1.0) == further_margin(5.0) == 0.2


def test_the_margin_grows_with_the_deviation_where_there_is_room() -> None:
    sure, unsure = planned(CORNER, 0.05).points, planned(CORNER, 0.25).points
    assert room_along(CORNER, unsure) > room_along(CORNER, sure) + 0.1
    assert lengths_along(unsure)[-1] < 1.15 * lengths_along(sure)[-1]


def test_a_door_without_that_room_is_still_passed() -> None:
    points = planned(DOOR, 1.0).points
    middle = points[np.abs(points[:, 0]) < 0.06]
    assert np.abs(middle[:, 1]).max() < 0.05  # the door is 0.5 m wide, and the robot 0.36 m


def test_a_robot_that_becomes_unsure_plans_anew() -> None:
    navigator = Navigator(CORNER, ObstacleLayer(CORNER), BASE, Noise(0, "test"))
    start = Pose2(-1.0, -1.0, 0.0)
    navigator.start(Goal("goal", (Pose2(1.0, -1.0, 0.0),), stop_at_each=False), start)
    plans = []
    for deviation in (0.05, 0.1, 0.25):
        moved(navigator, 1.5, ControlInput(start, AT_REST, NOTHING, np.zeros((0, 2)), False, 0, deviation))
        plans.append(navigator.plan)
    assert plans[0] is plans[1]
    assert plans[1] is not None and plans[2] is not None
    assert room_along(CORNER, plans[2].points) > room_along(CORNER, plans[1].points) + 0.1


def test_a_touched_place_is_an_obstacle_until_many_scans_pass_through_it() -> None:
    layer = ObstacleLayer(open_floor())
    layer.touch(np.array([(1.02, 0.02), (1.03, 0.02), (99.0, 0.0)]))  # the last one is beyond the map
    assert layer.points.tolist() == [[1.02, 0.02]]
    changes = layer.changes
    layer.touch(np.array([(1.02, 0.02)]))
    assert layer.changes == changes
    assert layer.hidden_points(HERE, thing_ahead(2.0)).tolist() == [[1.02, 0.02]]  # a scan sees past it
    layer.clear_seen()
    for _ in range(TOUCHED // 2):
        layer.update(HERE, NOTHING)
    assert len(layer.points) == 1
    for _ in range(TOUCHED // 2):
        layer.update(HERE, NOTHING)
    assert len(layer.points) == 0


def test_a_touched_place_at_a_seen_obstacle_is_cleared_with_it() -> None:
    layer = ObstacleLayer(open_floor())
    for _ in range(MOST):
        layer.update(HERE, thing_ahead(1.0))
    layer.touch(np.array([(0.9, 0.0)]))
    assert [0.9, 0.0] in layer.points.tolist()
    for _ in range(2 * MOST):
        layer.update(HERE, NOTHING)
    assert len(layer.points) == 0


def test_touched_places_that_leave_no_passage_are_forgotten() -> None:
    obstacles = ObstacleLayer(DOOR)
    obstacles.touch(np.array([(0.0, 0.02)]))
    navigator = Navigator(DOOR, obstacles, BASE, Noise(0, "test"))
    navigator.start(Goal("goal", (Pose2(1.0, 0.0, 0.0),), stop_at_each=False), STANDING.pose)
    moved(navigator, 0.2)
    assert navigator.plan is not None and len(obstacles.points) == 0


@pytest.mark.parametrize(
    ("bearing", "away"),
    [(0.0, 0.3), (math.pi, 0.1), (math.pi / 2, 0.2), (math.atan2(0.2, 0.3), math.hypot(0.2, 0.3))],
)
def test_the_distance_to_the_edge_of_a_footprint(bearing: float, away: float) -> None:
    footprint = Footprint(((-0.1, -0.2), (0.3, -0.2), (0.3, 0.2), (-0.1, 0.2)))
    assert footprint.distance_to_edge(bearing) == pytest.approx(away)
