from __future__ import annotations

from pathlib import Path

import pytest

from seoro.bridges import wire
from seoro.bridges.wire import Outcome
from tests.sim_nodes.client import ROBOT, Client, pose

OTHER = "second"
WORLD = """
name: pair
extent: [-5, -5, 5, 5]
walls:
  - {points: [[-2, -3], [4.5, -3], [4.5, 3], [-2, 3], [-2, -3]], thickness: 0.2, height: 1.0}
robots:
  - {name: turtlebot4, robot: turtlebot4}
  - {name: second, robot: turtlebot4, pose: {x: 2.0, y: 0.0, yaw: 3.141592653589793}}
"""


@pytest.fixture
def pair(tmp_path: Path) -> Client:
    path = tmp_path / "pair.yaml"
    path.write_text(WORLD)
    client = Client(str(path))
    client.localise()
    client.ask(wire.SET_INITIAL_POSE, wire.SetInitialPose(robot=OTHER, pose=pose(2.0, 0.0, 3.1415927)))
    return client


def test_unprefixed_frames_belong_to_the_first_robot(pair: Client) -> None:
    found = {}
    for frame in ("base_link", f"{ROBOT}/base_link", f"{OTHER}/base_link", f"{OTHER}_base_link_gt"):
        relative = wire.RelativePose(frame=frame, parent_frame="map", distance=0.0)
        found[frame] = round(pair.ask(wire.GET_RELATIVE_POSE, relative).position.x, 2)
    assert list(found.values()) == [0.0, 0.0, 2.0, 2.0]
    first, second = pair.ask(wire.GET_SIMULATOR_FEATURES, wire.Empty()).robots
    assert "base_link" in first.frames
    assert "base_link" not in second.frames


@pytest.mark.more
def test_one_robot_drives_around_the_other(pair: Client) -> None:
    pair.navigate(pose(3.5, 0.0))
    ended, contacts = pair.run_until("goal")
    assert (ended.outcome, contacts) == (Outcome.SUCCEEDED, [])
    assert pair.simulator.simulation.frames.true_pose(OTHER).distance(2.0, 0.0) < 1e-2


def test_robots_that_collide_are_reported(pair: Client) -> None:
    for robot in (ROBOT, OTHER):
        pair.simulator.simulation.engine.command_wheels(robot, 5.0, 5.0)
    [contact] = pair.advance(20.0).contacts
    assert (contact.first, contact.second) == (OTHER, ROBOT)
