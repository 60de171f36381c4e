from __future__ import annotations

import pytest

from seoro.bridges.wire import (
    GET_LOCALIZATION,
    REINITIALIZE_GLOBAL_LOCALIZATION,
    WATCH_LOCALIZATION,
    Empty,
    Localization,
    Result,
    RobotName,
    WatchLocalization,
)
from seoro.bridges.wire.refusal import RequestRefused
from tests.sim_nodes.client import ROBOT, Client, pose


def localization(client: Client) -> Localization:
    return client.ask(GET_LOCALIZATION, RobotName(robot=ROBOT))


def forget(client: Client) -> Empty:
    return client.ask(REINITIALIZE_GLOBAL_LOCALIZATION, RobotName(robot=ROBOT))


def test_localisation_can_be_queried(maze: Client) -> None:
    assert localization(maze) == Localization(pose=None, covariance=None, particles=0, error=None)
    maze.localise(pose(0.05, 0.0))
    found = localization(maze)
    assert found.pose is not None and found.pose.position.x == 0.05
    assert found.error == pytest.approx(0.05, abs=1e-3)
    assert found.covariance is not None and len(found.covariance) == 9
    assert found.covariance[0] == pytest.approx(0.1**2)
    assert found.particles == 2000


@pytest.mark.more
def test_a_watch_reports_when_a_global_search_succeeds(maze: Client) -> None:
    maze.localise()
    forget(maze)
    assert localization(maze).pose is None
    with pytest.raises(RequestRefused, match="is not localised") as refused:
        maze.navigate(pose(1.5, 0.0))
    assert refused.value.code == Result.INCORRECT_STATE
    maze.ask(WATCH_LOCALIZATION, WatchLocalization(id="found", robot=ROBOT))
    maze.simulator.simulation.engine.command_wheels(ROBOT, -2.6, 2.6)
    maze.run_until("found", 20.0)
    error = localization(maze).error
    assert error is not None and error < 0.15


def test_a_localised_robot_fulfils_a_watch_immediately(maze: Client) -> None:
    maze.localise()
    maze.ask(WATCH_LOCALIZATION, WatchLocalization(id="found", robot=ROBOT))
    assert maze.run_until("found")[0].time == 0.0


def test_a_global_search_is_refused_during_a_goal(maze: Client) -> None:
    maze.localise()
    maze.navigate(pose(1.5, 0.0))
    with pytest.raises(RequestRefused, match="cancel it before"):
        forget(maze)
