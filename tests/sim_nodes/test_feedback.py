from __future__ import annotations

import pytest

from seoro.bridges.wire import (
    GET_NAVIGATION_FEEDBACK,
    NAVIGATE_THROUGH_POSES,
    NavigateThroughPoses,
    NavigationFeedback,
    RobotName,
)
from seoro.bridges.wire.refusal import RequestRefused
from tests.sim_nodes.client import ROBOT, Client, pose


def navigate(client: Client, period: float) -> None:
    poses = (pose(1.5, -1.5), pose(1.5, -3.0))
    request = NavigateThroughPoses(id="goal", robot=ROBOT, poses=poses, feedback_period=period)
    client.ask(NAVIGATE_THROUGH_POSES, request)


def feedback(client: Client) -> NavigationFeedback:
    return client.ask(GET_NAVIGATION_FEEDBACK, RobotName(robot=ROBOT))


def test_a_robot_sends_feedback_once_per_period(maze: Client) -> None:
    maze.localise()
    navigate(maze, 2.0)
    reported: list[NavigationFeedback] = []
    while (advanced := maze.advance(10.0)).time < 10.0:
        assert advanced.feedback
        reported += advanced.feedback
    assert [round(each.navigation_time, 6) for each in reported] == [2.0, 4.0, 6.0, 8.0]
    ways = [each.distance_remaining for each in reported]
    assert ways == sorted(ways, reverse=True)
    assert ways[0] - ways[-1] == pytest.approx(6.0 * 0.3, abs=0.4)
    last = reported[-1]
    assert (last.robot, last.number_of_recoveries, last.number_of_poses_remaining) == (ROBOT, 0, 2)
    assert last.estimated_time_remaining == pytest.approx(last.distance_remaining / 0.25, rel=0.2)
    now = feedback(maze)
    assert now.navigation_time > 9.5
    assert now.distance_remaining < ways[-1]


def test_grants_are_not_cut_without_a_feedback_period(maze: Client) -> None:
    maze.localise()
    navigate(maze, 0.0)
    assert maze.advance(5.0).time == 5.0


def test_feedback_without_a_goal_is_refused(maze: Client) -> None:
    with pytest.raises(RequestRefused, match="has no active goal"):
        feedback(maze)


@pytest.mark.parametrize("period", [-1.0, float("nan"), float("inf")])
def test_a_negative_feedback_period_is_refused(maze: Client, period: float) -> None:
    maze.localise()
    with pytest.raises(RequestRefused, match="invalid feedback period"):
        navigate(maze, period)
