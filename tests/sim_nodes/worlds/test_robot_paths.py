"""Robots of world files that follow a path from the start."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.bridges import wire
from sim_nodes.__main__ import ENGINES
from sim_nodes.worlds.loader import WorldError, parse_world
from tests.sim_nodes.client import ROBOT, Client

WORLD = """
name: w
extent: [-3, -3, 3, 3]
walls:
  - {points: [[-2.9, 2], [2.9, 2]]}
robots:
  - {name: turtlebot4, robot: turtlebot4, MORE}
"""


def position(client: Client) -> tuple[float, ...]:
    return client.simulator.simulation.engine.body_state(ROBOT).position[:2]


@pytest.mark.parametrize("engine", ENGINES)
def test_a_robot_follows_its_path_until_a_command(engine: str, tmp_path: Path) -> None:
    path = tmp_path / "w.yaml"
    path.write_text(WORLD.replace("MORE", "path: {points: [[0.6, 0], [0, 0]], repeat: true}, speed: 0.25"))
    client = Client(str(path), engine=engine)
    client.advance(3.0)
    snapshot = client.ask(wire.SAVE_STATE, wire.Empty())
    assert position(client)[0] > 0.4
    client.advance(7.0)
    back = position(client)
    assert back[0] < 0.35
    client.ask(wire.RESTORE_STATE, wire.RestoreState(snapshot=snapshot, purpose=wire.Purpose.CONTINUE))
    client.advance(7.0)
    assert position(client) == back
    client.ask(wire.DRIVE, wire.Drive(id="drive", robot=ROBOT, linear=0.0, angular=0.0, duration=1.0))
    client.run_until("drive")
    before = position(client)
    client.advance(client.simulator.time + 2.0)
    assert position(client) == pytest.approx(before, abs=0.01)
    client.ask(wire.RESET_SIMULATION, wire.ResetSimulation(scope=wire.ResetScope.STATE))
    client.advance(client.simulator.time + 3.0)
    assert position(client)[0] > 0.4


@pytest.mark.parametrize(
    ("more", "error"),
    [
        ("speed: 0.2", "unexpected `speed` without `path`"),
        (
            "path: {points: [[1, 0]]}, speed: 3.0",
            r"robots\.0\.speed: invalid speed 3 m/s .* at most 0\.306",
        ),
        ("path: {points: [[0, 2.5]]}", r"robots\.0\.path: the way from .* expected .* add points around it"),
        ("path: {points: [[0, 9]]}", r"robots\.0\.path: \(0, 9\) is outside of the world"),
    ],
)
def test_invalid_paths_are_refused(more: str, error: str) -> None:
    with pytest.raises(WorldError, match=error):
        parse_world(WORLD.replace("MORE", more), "w.yaml")


def test_robots_that_do_not_drive_have_no_path() -> None:
    arm = WORLD.replace("robot: turtlebot4", "robot: ur10e").replace("MORE", "path: {points: [[1, 0]]}")
    with pytest.raises(WorldError, match=r"robots\.0\.path: unexpected path: a ur10e does not drive"):
        parse_world(arm, "w.yaml")
