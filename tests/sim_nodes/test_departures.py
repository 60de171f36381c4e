"""Robots that leave their world, are lost by the physics, or start inside of an obstacle, in real engines."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from seoro.bridges import wire
from seoro.bridges.wire.refusal import RequestRefused
from tests.sim_nodes.client import ROBOT, Client, pose

ENGINES = pytest.mark.parametrize("engine", ["mujoco", "pybullet"])

WORLD = """name: w
extent: [-2, -2, 2, 2]
walls: [{name: barrier, center: [0.0, 1.5], size: [2.0, 0.1]}]
props:
  - {name: pillar, cylinder: {radius: 0.1, length: 1.0}, pose: {x: -1.0}}
  - {name: plate, box: [0.4, 0.4, 0.05], pose: {x: 1.0, y: -1.0}}
robots: [{name: turtlebot4, robot: KIND, pose: {POSE}}]
"""


def client(folder: Path, engine: str, place: str, kind: str = "turtlebot4") -> Client:
    pytest.importorskip(engine)
    path = folder / "w.yaml"
    path.write_text(WORLD.replace("KIND", kind).replace("POSE", place))
    return Client(str(path), engine=engine)


def leave(robot: Client, limit: float = 5.0) -> wire.Departure:
    """Grant time until a robot leaves."""
    while True:
        advanced = robot.advance(limit)
        if advanced.departures:
            (departure,) = advanced.departures
            assert departure.time == advanced.time
            return departure
        assert advanced.time < limit, "no robot left"


@ENGINES
def test_a_robot_that_drives_out_of_its_world_is_reported_once_each_time(tmp_path: Path, engine: str) -> None:
    robot = client(tmp_path, engine, "x: 1.8")
    robot.ask(wire.DRIVE, wire.Drive(id="out", robot=ROBOT, linear=0.3, angular=0.0, duration=3.0))
    departure = leave(robot)
    assert (departure.robot, departure.extent) == (ROBOT, (-2.0, -2.0, 2.0, 2.0))
    assert departure.position.x == pytest.approx(2.0, abs=0.01)
    assert robot.run_until("out")[0].outcome == wire.Outcome.SUCCEEDED
    assert not robot.advance(8.0).departures
    back = wire.SetEntityState(name=ROBOT, pose=pose(1.9, 0.0))
    robot.ask(wire.SET_ENTITY_STATE, back)
    robot.advance(8.1)
    robot.ask(wire.DRIVE, wire.Drive(id="again", robot=ROBOT, linear=0.3, angular=0.0, duration=3.0))
    assert leave(robot, 12.0).time > 8.1


@ENGINES
def test_a_robot_cannot_be_moved_outside_of_its_world(tmp_path: Path, engine: str) -> None:
    robot = client(tmp_path, engine, "x: 0.0")
    with pytest.raises(RequestRefused, match=r"'turtlebot4' at .2.50, 0.00. would be outside of the world"):
        robot.ask(wire.SET_ENTITY_STATE, wire.SetEntityState(name=ROBOT, pose=pose(2.5, 0.0)))


@ENGINES
def test_a_robot_lost_by_the_physics_is_reported_as_a_node_fault(tmp_path: Path, engine: str) -> None:
    robot = client(tmp_path, engine, "x: 0.0")
    physics = robot.simulator.simulation.engine
    here = physics.body_state(ROBOT)
    physics.set_body_state(ROBOT, replace(here, position=(0.0, 0.0, -50.0)))
    with pytest.raises(
        RequestRefused, match=r"lost the robot 'turtlebot4': it is at .* expected a height from -0.5 m to"
    ) as caught:
        robot.advance(0.1)
    assert caught.value.code == wire.LabResult.FAULT


@ENGINES
@pytest.mark.parametrize(
    ("place", "kind", "other"),
    [
        ("y: 1.5", "turtlebot4", "barrier"),
        ("x: -1.1", "turtlebot4", "pillar"),
        ("x: -1.6, y: -0.17", "ur10e", "pillar"),
    ],
)
def test_a_robot_that_starts_inside_an_obstacle_is_refused(
    tmp_path: Path, engine: str, place: str, kind: str, other: str
) -> None:
    with pytest.raises(
        RequestRefused, match=f"w: the robot 'turtlebot4' at x .* m overlaps {other}; expected a `pose`"
    ):
        client(tmp_path, engine, place, kind)


@ENGINES
@pytest.mark.parametrize(("place", "kind"), [("y: 1.2", "turtlebot4"), ("x: 1.0, y: -1.0", "ur10e")])
def test_a_robot_may_start_beside_an_obstacle(tmp_path: Path, engine: str, place: str, kind: str) -> None:
    assert client(tmp_path, engine, place, kind).advance(0.1).departures == ()
