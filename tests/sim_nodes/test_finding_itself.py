from __future__ import annotations

import pytest

from seoro.bridges.wire import (
    GET_LOCALIZATION,
    REINITIALIZE_GLOBAL_LOCALIZATION,
    WATCH_LOCALIZATION,
    Empty,
    LocalisedRobot,
    Localization,
    Result,
    WatchLocalization,
)
from seoro.bridges.wire.refusal import RequestRefused
from tests.sim_nodes.client import ROBOT, Client, pose


def localization(client: Client) -> Localization:
    return client.ask(GET_LOCALIZATION, LocalisedRobot(robot=ROBOT))


def forget(client: Client) -> Empty:
    return client.ask(REINITIALIZE_GLOBAL_LOCALIZATION, LocalisedRobot(robot=ROBOT))


def test_what_the_localisation_says_can_be_asked_for(maze: Client) -> None:
    assert localization(maze) == Localization(pose=None, covariance=None, particles=0, error=None)
    maze.localise(pose(0.05, 0.0))
    found = localization(maze)
    assert found.pose is not None and found.pose.position.x == 0.05
    assert found.error == pytest.approx(0.05, abs=1e-3)
    assert found.covariance is not None and len(found.covariance) == 9
    assert found.covariance[0] == pytest.approx(0.1**2)
    assert found.particles == 2000


def test_a_robot_that_forgets_where_it_is_says_when_it_has_found_itself(maze: Client) -> None:
    maze.localise()
    forget(maze)
    assert localization(maze).pose is None
    with pytest.raises(RequestRefused, match="does not know where it is") as refused:
        maze.navigate(pose(1.5, 0.0))
    assert refused.value.code == Result.INCORRECT_STATE
    maze.ask(WATCH_LOCALIZATION, WatchLocalization(id="found", robot=ROBOT))
    maze.simulator.simulation.engine.command_wheels(ROBOT, -2.6, 2.6)
    maze.run_until("found", 20.0)
    error = localization(maze).error
    assert error is not None and error < 0.15


def test_a_robot_that_knows_where_it_is_says_so_at_once(maze: Client) -> None:
    maze.localise()
    maze.ask(WATCH_LOCALIZATION, WatchLocalization(id="found", robot=ROBOT))
    assert maze.run_until("found")[0].time == 0.0


def test_a_robot_on_its_way_does_not_forget_where_it_is(maze: Client) -> None:
    maze.localise()
    maze.navigate(pose(1.5, 0.0))
    with pytest.raises(RequestRefused, match="cancel it before"):
        forget(maze)
