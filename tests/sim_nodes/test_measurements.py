from __future__ import annotations

import json
import math

import pytest

from seoro.bridges.wire import (
    GET_ARTIFACTS,
    GET_MEASUREMENTS,
    RESET_SIMULATION,
    Empty,
    Outcome,
    ResetScope,
    ResetSimulation,
    RobotMeasurements,
)
from sim_nodes.geometry import Pose2
from sim_nodes.run_data import RobotMetrics
from tests.sim_nodes.client import ROBOT, Client, pose


def measured(client: Client) -> RobotMeasurements:
    return client.ask(GET_MEASUREMENTS, Empty()).robots[ROBOT]


def test_errors_are_means_over_time_and_while_moving() -> None:
    measuring = RobotMetrics(Pose2(0.0, 0.0, 0.0), lambda pose: 2.0 - pose.x)
    measuring.update(Pose2(0.0, 0.0, 0.0), None, None, 0)  # not localised yet
    for i in range(1, 101):
        measuring.update(Pose2(0.01 * i, 0.0, 0.0), Pose2(0.01 * i, 0.1, 0.0), 0.05, i)
    for i in range(101, 201):
        measuring.update(Pose2(1.0, 0.0, 0.0), Pose2(1.0, 0.3, 0.0), 0.07, i)
    measuring.count_contact()
    for goal, outcome in (("a", Outcome.SUCCEEDED), ("b", Outcome.ABORTED)):
        measuring.start_goal(goal)
        measuring.end_goal("turn", Outcome.SUCCEEDED)  # no goal of the navigation
        measuring.end_goal(goal, outcome)
    result = measuring.result(3)
    assert result.path_length == pytest.approx(1.0)
    assert result.driving_time == pytest.approx(2.0)
    assert result.localisation_error == pytest.approx(0.2)
    assert result.localisation_error_driving == pytest.approx(0.1)
    assert result.localisation_error_max == pytest.approx(0.3)
    assert result.localisation_deviation == pytest.approx(0.06)
    assert result.closest_approach == pytest.approx(1.0)
    ends = (result.contacts, result.goals_reached, result.goals_aborted, result.goals_canceled, result.recoveries)
    assert ends == (1, 1, 1, 0, 3)


def test_measurements_without_values_are_none() -> None:
    result = RobotMetrics(Pose2(0.0, 0.0, 0.0), lambda pose: math.inf).result(0)
    assert result.localisation_error is None
    assert result.closest_approach is None
    assert result.path_length == 0.0


def test_measurements_of_a_drive_are_returned(maze: Client) -> None:
    maze.localise()
    maze.navigate(pose(1.5, 0.0))
    maze.run_until("goal")
    result = measured(maze)
    assert 1.4 < result.path_length < 4.5
    assert result.goals_reached == 1
    assert result.localisation_error is not None and result.localisation_error_max is not None
    assert 0.0 < result.localisation_error < result.localisation_error_max < 0.12
    assert result.closest_approach is not None and 0.0 < result.closest_approach < 0.75 - 0.164
    assert 0.5 * result.path_length / 0.306 < result.driving_time <= maze.simulator.simulation.time
    (file,) = (each for each in maze.ask(GET_ARTIFACTS, Empty()).artifacts if each.name == "measurements.json")
    written = json.loads(file.data)
    assert (written["world"], written["engine"], written["seed"]) == ("maze", "mujoco", 0)
    assert RobotMeasurements.model_validate(written["robots"][ROBOT]) == result


def test_spawned_bodies_count_for_the_closest_approach(empty: Client) -> None:
    before = measured(empty)
    assert before.closest_approach is None
    empty.localise()
    empty.spawn("box", pose(1.0, 0.6, z=0.1))
    empty.navigate(pose(2.0, 0.0))
    empty.run_until("goal")
    closest = measured(empty).closest_approach
    assert closest is not None and 0.05 < closest < 0.6


def test_a_reset_restarts_measurements(maze: Client) -> None:
    maze.localise()
    maze.navigate(pose(1.5, 0.0))
    maze.advance(3.0)
    assert measured(maze).path_length > 0.2
    maze.ask(RESET_SIMULATION, ResetSimulation(scope=ResetScope.STATE))
    assert measured(maze).path_length == 0.0
