"""Robots that follow a path by their true pose."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import pytest

from seoro.bridges import wire
from seoro.bridges.wire import Outcome
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.__main__ import ENGINES
from sim_nodes.check.drives import drive_of
from sim_nodes.geometry import Pose2
from sim_nodes.robots.drive_declaration import DriveKind
from sim_nodes.robots.path_following import PathFollower
from sim_nodes.ticks import TICK
from tests.sim_nodes.client import ROBOT, Client, pose
from tests.sim_nodes.graph import differences

on_both = pytest.mark.parametrize("engine", ENGINES)

CORNER = ((1.0, 0.0), (1.0, 1.0))
OTHER = "other"
WORLD = """
name: square
extent: [-5, -5, 5, 5]
walls:
  - {points: [[-4.9, -4.9], [4.9, -4.9]]}
robots:
  - {name: turtlebot4, robot: turtlebot4}
  - {name: other, robot: turtlebot4, pose: {x: 1.2, y: 1.0, yaw: -1.57}}
"""


@pytest.fixture
def world(tmp_path: Path) -> str:
    path = tmp_path / "square.yaml"
    path.write_text(WORLD)
    return str(path)


def follow(
    client: Client,
    *points: tuple[float, float],
    robot: str = ROBOT,
    goal: str = "path",
    speed: float = 0.0,
    repeat: bool = False,
) -> None:
    path = tuple(wire.Position3D(*point) for point in points)
    client.ask(wire.FOLLOW_PATH, wire.FollowPath(id=goal, robot=robot, points=path, speed=speed, repeat=repeat))


@on_both
def test_a_robot_follows_a_path_to_its_last_point(engine: str, empty: Client) -> None:
    client = Client("empty", 0, engine)
    follow(client, *CORNER)
    farthest = 0.0
    while not (ended := client.advance(client.simulator.time + 0.2).occurrences):
        x, y = client.truth.x, client.truth.y
        farthest = max(farthest, min(abs(y), math.hypot(x - 1.0, 0.0) if y > 0.0 else math.inf))
    assert ended[0].outcome is Outcome.SUCCEEDED
    assert client.truth.distance(1.0, 1.0) < 0.05
    assert farthest < 0.1
    assert 6.0 < ended[0].time < 9.0
    client.advance(client.simulator.time + 0.5)
    assert client.truth.distance(1.0, 1.0) < 0.05


def test_a_repeated_path_goes_on_until_it_is_cancelled() -> None:
    client = Client("empty")
    follow(client, (0.8, 0.0), (0.1, 0.0), repeat=True)
    places = [client.truth]
    while client.simulator.time < 20.0:
        assert client.advance(client.simulator.time + 1.0).occurrences == ()
        places.append(client.truth)
    for x in (0.8, 0.1):
        assert sum(abs(place.x - x) < 0.15 for place in places) > 2
    client.ask(wire.CANCEL_GOAL, wire.CancelGoal(id="path"))
    [ended] = client.advance(client.simulator.time + 1.0).occurrences
    assert ended.outcome is Outcome.CANCELED
    before = client.truth
    client.advance(client.simulator.time + 1.0)
    assert client.truth.distance(before.x, before.y) < 0.01


@on_both
def test_a_robot_on_a_path_is_seen_and_strikes(engine: str, world: str) -> None:
    client = Client(world, 0, engine)
    lidar = client.simulator.simulation.pipeline(ROBOT, "lidar")
    lidar.in_use = True
    follow(client, (1.2, 0.0), (0.2, 0.0), robot=OTHER)
    contacts: list[wire.Contact] = []
    while not contacts:
        contacts += client.advance(client.simulator.time + 1.0).contacts
    assert (contacts[0].first, contacts[0].second, contacts[0].strikers) == (OTHER, ROBOT, (OTHER,))
    assert lidar.latest is not None
    assert float(lidar.latest.data.ranges.min()) < 0.5


def test_a_blocked_robot_gives_up(world: str) -> None:
    client = Client(world)
    for name, y in (("guest", 0.26), ("friend", -0.26)):
        client.ask(wire.SPAWN_PERSON, wire.SpawnPerson(name=name, pose=pose(0.6, y)))
    follow(client, (3.0, 0.0))
    ended, _ = client.run_until("path")
    assert ended.outcome is Outcome.ABORTED
    assert ended.message.startswith("the robot is blocked at (")
    assert ended.message.endswith("no progress in 20 s")


def test_a_car_follows_a_path_in_curves() -> None:
    drive = drive_of(DriveKind.ACKERMANN)
    follower, here = PathFollower(drive), Pose2(0.0, 0.0, 0.0)
    follower.start(((0.0, 0.0), (3.0, 0.0), (3.0, 4.0), (-2.0, 4.0)), 0.8, 0, "path", repeat=False)
    for tick in range(2000):
        velocity, ended = follower.control(here, tick)
        if ended is not None:
            break
        assert abs(velocity.angular) <= abs(velocity.linear) / drive.min_turning_radius + 1e-9
        turned = here.yaw + velocity.angular * TICK
        here = here.compose(Pose2(velocity.linear * TICK, 0.0, 0.0))
        here = Pose2(here.x, here.y, turned)
    assert ended is not None and ended.outcome is Outcome.SUCCEEDED
    assert here.distance(-2.0, 4.0) < 0.1


def test_a_snapshot_has_the_path() -> None:
    original = Client("empty")
    follow(original, *CORNER)
    original.advance(4.31)
    fork = Client("maze", 9)
    snapshot = original.ask(wire.SAVE_STATE, wire.Empty())
    fork.ask(wire.RESTORE_STATE, wire.RestoreState(snapshot=snapshot))
    assert differences(original.simulator.simulation, fork.simulator.simulation) == []
    assert fork.run_until("path") == original.run_until("path")
    assert fork.truth == original.truth


def test_invalid_paths_are_refused(world: str) -> None:
    client = Client(world)
    follow(client, (0.5, 0.0), robot=OTHER, goal="busy")
    cases: list[tuple[str, Callable[[], None]]] = [
        ("found 0 points of a path; expected 1 to 100", lambda: follow(client)),
        ("is busy with goal 'busy'", lambda: follow(client, (1.0, 0.0), robot=OTHER)),
        (r"\(7, 0\) is outside of the world", lambda: follow(client, (7.0, 0.0))),
        ("m from a wall at", lambda: follow(client, (0.0, -4.8))),
        ("expected up to 0.306 m/s", lambda: follow(client, (1.0, 0.0), speed=2.0)),
        ("speed", lambda: follow(client, (1.0, 0.0), speed=-1.0)),
    ]
    for words, request in cases:
        with pytest.raises(RequestRefused, match=words):
            request()
