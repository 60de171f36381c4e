"""Doors and lifts: motions, locks, automatic doors, obstacles, carried loads, snapshots."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from seoro.bridges import wire
from seoro.bridges.wire import Outcome
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes import snapshots
from sim_nodes.buildings.parts import Door
from tests.sim_nodes.client import ROBOT, Client, pose
from tests.sim_nodes.engines import PYBULLET_IN_MORE
from tests.sim_nodes.graph import differences

on_both = pytest.mark.parametrize("engine", PYBULLET_IN_MORE)

WORLD = """
name: building
extent: [-5, -5, 5, 5]
walls:
  - {points: [[0, -4.9], [0, -0.5]]}
  - {points: [[0, 0.5], [0, 4.9]]}
robots:
  - {name: turtlebot4, robot: turtlebot4, pose: {x: -1.5, y: 0}}
"""
DOOR = "doors:\n  - {name: front, pose: {x: 0, y: 0}, MORE}\n"
LIFT = """
lifts:
  - {name: hoist, pose: {x: -2, y: 2}, floors: [0.0, 0.4]}
"""


@pytest.fixture
def world(tmp_path: Path) -> Path:
    return tmp_path / "building.yaml"


def open_world(path: Path, more: str, engine: str = "mujoco") -> Client:
    path.write_text(WORLD + more)
    return Client(str(path), 1, engine)


def move(client: Client, opening: float, goal: str = "door") -> None:
    client.ask(wire.MOVE_DOOR, wire.MoveDoor(id=goal, door="front", opening=opening))


def opening(client: Client) -> float:
    found = client.simulator.simulation.building_position("front")
    assert found is not None
    return found


def place(client: Client, name: str) -> tuple[float, float, float]:
    return client.simulator.simulation.engine.body_state(name).position


def drive(client: Client, duration: float) -> list[wire.Contact]:
    client.ask(wire.DRIVE, wire.Drive(id="drive", robot=ROBOT, linear=0.3, angular=0.0, duration=duration))
    _, contacts = client.run_until("drive")
    return contacts


def advance(client: Client, duration: float) -> list[wire.Contact]:
    contacts: list[wire.Contact] = []
    end = client.simulator.time + duration
    while client.simulator.time < end - 1e-9:
        contacts += client.advance(end).contacts
    return contacts


# Poses of leaves are those of the middle of their lower edge.
@pytest.mark.parametrize(
    ("kind", "leaf", "there"),
    [
        ("kind: hinged", "front", (0.445, 0.45)),
        ("kind: hinged, side: right, angle: -1.5707963", "front", (-0.445, -0.45)),
        ("kind: sliding, way: 0.8", "front", (0.0, 0.805)),
        ("kind: sliding, leaves: 2", "front_right", (0.0, -0.67)),
    ],
)
@on_both
def test_leaves_open_to_their_side_without_contacts(
    engine: str, kind: str, leaf: str, there: tuple[float, float], world: Path
) -> None:
    client = open_world(world, DOOR.replace("MORE", kind + ", speed: 1.0"), engine)
    move(client, 1.0)
    ended, contacts = client.run_until("door")
    assert (ended.outcome, contacts) == (Outcome.SUCCEEDED, [])
    x, y, z = place(client, leaf)
    assert (x, y) == pytest.approx(there, abs=2e-3)
    assert z == pytest.approx(0.01, abs=2e-3)


@on_both
def test_a_closed_door_stops_a_robot_and_is_seen(engine: str, world: Path) -> None:
    client = open_world(world, DOOR.replace("MORE", "kind: hinged"), engine)
    lidar = client.simulator.simulation.pipeline(ROBOT, "lidar")
    lidar.in_use = True
    [contact, *_] = drive(client, 6.0)
    assert (contact.first, contact.second, contact.strikers) == ("front", ROBOT, (ROBOT,))
    assert client.truth.x < -0.15
    assert place(client, "front") == pytest.approx((0.0, 0.005, 0.01), abs=5e-3)
    assert lidar.latest is not None
    assert float(lidar.latest.data.ranges.min()) < 0.25


@on_both
def test_a_closing_door_stops_before_a_robot_and_reports_it(engine: str, world: Path) -> None:
    client = open_world(world, DOOR.replace("MORE", "kind: sliding, opening: 1.0"), engine)
    assert drive(client, 5.0) == []
    before = client.truth
    move(client, 0.0)
    ended, contacts = client.run_until("door")
    assert ended.outcome is Outcome.ABORTED
    assert ended.message.startswith("the door front is blocked by turtlebot4, 6")
    assert contacts[0].strikers == ("front",)
    assert client.truth.distance(before.x, before.y) < 0.03
    assert opening(client) > 0.5
    client.ask(wire.SET_ENTITY_STATE, wire.SetEntityState(name=ROBOT, pose=pose(-1.5, 0.0)))
    move(client, 0.0, "again")
    ended, contacts = client.run_until("again")
    assert (ended.outcome, contacts) == (Outcome.SUCCEEDED, [])


@on_both
def test_an_automatic_door_opens_for_robots_and_people(engine: str, world: Path) -> None:
    more = "kind: sliding, leaves: 2, speed: 1.0, automatic: {range: 1.0, hold: 0.5}"
    people = "people:\n  - {name: guest, pose: {x: 2.0, y: 0}, speed: 2.0, avoid: none}\n"
    client = open_world(world, DOOR.replace("MORE", more) + people, engine)
    walk = wire.WalkAlong(id="walk", person="guest", points=(wire.Position3D(0.9, 0.0),))
    client.ask(wire.WALK_ALONG, walk)
    client.ask(wire.WATCH_DOOR, wire.WatchDoor(id="open", door="front", least=1.0))
    opened, _ = client.run_until("open")
    assert opened.time < 2.5
    back = wire.WalkAlong(id="back", person="guest", points=(wire.Position3D(2.0, 0.0),))
    client.ask(wire.WALK_ALONG, back)
    client.ask(wire.WATCH_DOOR, wire.WatchDoor(id="closed", door="front", most=0.0))
    closed, _ = client.run_until("closed")
    assert opened.time + 0.5 < closed.time < opened.time + 4.0
    assert drive(client, 9.0) == []
    assert client.truth.x > 0.9


def test_an_automatic_door_opens_again_before_an_obstacle(world: Path) -> None:
    more = "kind: sliding, automatic: {range: 0.4, hold: 0.2}"
    client = open_world(world, DOOR.replace("MORE", more))
    move(client, 1.0)
    client.run_until("door")
    client.spawn("box", pose(0.0, 0.0, z=0.1))
    contacts = advance(client, 1.5)
    assert [(each.first, each.second) for each in contacts] == [("box", "front")]
    assert opening(client) > 0.5
    client.ask(wire.WATCH_DOOR, wire.WatchDoor(id="open", door="front", least=1.0))
    client.run_until("open")


def test_locked_doors_stay_closed(world: Path) -> None:
    more = "kind: sliding, locked: true, automatic: {range: 5.0}"
    client = open_world(world, DOOR.replace("MORE", more))
    with pytest.raises(RequestRefused, match="front is locked; unlock it first"):
        move(client, 1.0)
    advance(client, 1.0)
    assert opening(client) == 0.0
    client.ask(wire.LOCK_DOOR, wire.LockDoor(door="front", locked=False))
    advance(client, 1.0)
    assert opening(client) > 0.1
    with pytest.raises(RequestRefused, match=r"front is \d+ % open; close it before you lock it"):
        client.ask(wire.LOCK_DOOR, wire.LockDoor(door="front"))


def test_goals_of_doors_are_cancelled_and_refuse_another(world: Path) -> None:
    client = open_world(world, DOOR.replace("MORE", "kind: hinged"))
    move(client, 1.0)
    with pytest.raises(RequestRefused, match="front is busy with goal 'door'"):
        move(client, 0.0, "second")
    advance(client, 1.0)
    client.ask(wire.CANCEL_GOAL, wire.CancelGoal(id="door"))
    [ended] = client.advance(client.simulator.time + 0.1).occurrences
    assert (ended.id, ended.outcome) == ("door", Outcome.CANCELED)
    there = opening(client)
    advance(client, 0.5)
    assert 0.1 < there == opening(client) < 0.5
    client.ask(wire.RESET_SIMULATION, wire.ResetSimulation(scope=wire.ResetScope.STATE))
    assert opening(client) == 0.0


@on_both
def test_a_lift_carries_a_robot_and_a_crate(engine: str, world: Path) -> None:
    crate = "props:\n  - {name: crate, box: [0.2, 0.2, 0.2], mass: 5.0, pose: {x: -2.4, y: 2.4}}\n"
    client = open_world(world, LIFT + crate, engine)
    client.ask(wire.SET_ENTITY_STATE, wire.SetEntityState(name=ROBOT, pose=pose(-3.2, 2.0)))
    assert drive(client, 4.0) == []
    x, y, low = place(client, ROBOT)
    client.ask(wire.MOVE_LIFT, wire.MoveLift(id="up", lift="hoist", floor=1))
    ended, contacts = client.run_until("up")
    assert (ended.outcome, contacts) == (Outcome.SUCCEEDED, [])
    assert place(client, ROBOT) == pytest.approx((x, y, low + 0.4), abs=0.01)
    assert place(client, "crate") == pytest.approx((-2.4, 2.4, 0.5), abs=2e-3)
    client.ask(wire.WATCH_LIFT, wire.WatchLift(id="there", lift="hoist", floor=0))
    client.ask(wire.MOVE_LIFT, wire.MoveLift(id="down", lift="hoist", floor=0))
    client.run_until("there")
    advance(client, 0.3)
    assert place(client, "crate") == pytest.approx((-2.4, 2.4, 0.1), abs=2e-3)


@on_both
def test_a_lift_stops_above_a_robot(engine: str, world: Path) -> None:
    client = open_world(world, LIFT.replace("0.4]", "0.5], start: 1"), engine)
    client.ask(wire.SET_ENTITY_STATE, wire.SetEntityState(name=ROBOT, pose=pose(-3.2, 2.0)))
    assert drive(client, 4.0) == []
    client.ask(wire.MOVE_LIFT, wire.MoveLift(id="down", lift="hoist", floor=0))
    ended, contacts = client.run_until("down")
    assert ended.outcome is Outcome.ABORTED
    assert "the lift hoist is blocked by turtlebot4, at a height of 0." in ended.message
    assert contacts[0].strikers == ("hoist",)
    x, y, z = place(client, ROBOT)
    assert (x, y) == pytest.approx((-2.05, 2.0), abs=0.05)
    assert abs(z) < 0.01


GUEST = "people: [{name: guest, pose: {x: 3}}]\n"
BUSY = DOOR.replace("MORE", "kind: hinged, automatic: {range: 2.5}") + LIFT + GUEST


def busy(world: Path, engine: str) -> Client:
    """Return a client of a robot before an automatic door, with a lift and a person that move."""
    client = open_world(world, BUSY, engine)
    client.ask(wire.MOVE_LIFT, wire.MoveLift(id="up", lift="hoist", floor=1))
    area = (wire.Position3D(1.0, -2.0), wire.Position3D(3.0, 2.0))
    client.ask(wire.WANDER, wire.Wander(id="wander", person="guest", lower=area[0], upper=area[1]))
    client.ask(wire.DRIVE, wire.Drive(id="go", robot=ROBOT, linear=0.3, angular=0.05, duration=6.0))
    client.ask(wire.WATCH_DOOR, wire.WatchDoor(id="open", door="front", least=1.0))
    client.advance(0.71)
    return client


@on_both
def test_a_snapshot_has_doors_and_lifts(engine: str, world: Path, tmp_path: Path) -> None:
    original = busy(world, engine)
    fork = Client("empty", 9, engine)
    snapshot = original.ask(wire.SAVE_STATE, wire.Empty())
    fork.ask(wire.RESTORE_STATE, wire.RestoreState(snapshot=snapshot))
    assert differences(original.simulator.simulation, fork.simulator.simulation) == []
    for client in (original, fork):
        advance(client, 2.0)
    assert differences(original.simulator.simulation, fork.simulator.simulation) == []
    for name in ("front", "hoist", "guest", ROBOT):
        assert place(original, name) == place(fork, name)


@on_both
def test_doors_and_lifts_are_simulated_ahead(engine: str, world: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(snapshots, "LONGEST", 60.0)
    direct, ahead = busy(world, engine), busy(world, engine)
    went = 0
    while direct.simulator.time < 3.0:
        until = direct.simulator.time + 0.1
        seen = direct.advance(until)
        there = ahead.ask(wire.ADVANCE, wire.Advance(until=until, horizon=until + 0.5))
        went += there.time > until + 0.2
        ahead.ask(wire.REWIND, wire.Rewind(time=seen.time))
    assert went > 5
    for name in ("front", "hoist", "guest", ROBOT):
        assert place(direct, name) == place(ahead, name)


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ("doors:\n  - {name: a, width: 0.1}\n", "width"),
        (
            "doors:\n  - {name: a, kind: sliding, angle: 1}\n",
            "unexpected `angle` of a sliding door; expected `way`",
        ),
        ("doors:\n  - {name: a, way: 1.0}\n", "unexpected `way` of a hinged door; expected `angle`"),
        ("doors:\n  - {name: a, angle: 0.1}\n", "invalid `angle` 0.1; expected 0.2 rad or more"),
        (
            "doors:\n  - {name: a, leaves: 2, side: left}\n",
            "unexpected `side`: a door with two leaves",
        ),
        ("doors:\n  - {name: a, locked: true, opening: 0.5}\n", "unexpected `opening` of a locked door"),
        ("doors:\n  - {name: a, pose: {x: 9}}\n", r"doors.0.pose: 'a' at \(9, 0\) is outside of the world"),
        ("doors:\n  - {name: turtlebot4}\n", "duplicate name 'turtlebot4' of a door"),
        ("doors:\n  - {name: a, pose: {x: -1.5}}\n", r"the door 'a' at \(-1.50, 0.01\) overlaps turtlebot4"),
        ("lifts:\n  - {name: a, floors: [1.0, 0.5]}\n", "invalid `floors`; expected ascending heights"),
        ("lifts:\n  - {name: a, floors: [0.0, 0.5], start: 2}\n", "unknown floor 2 in `start`; expected 0 to 1"),
        (
            "doors:\n" + "".join(f"  - {{name: a{number}, pose: {{x: 2}}}}\n" for number in range(51)),
            "found 51 doors and lifts; expected at most 50",
        ),
    ],
)
def test_invalid_doors_and_lifts_are_refused(more: str, words: str, world: Path) -> None:
    with pytest.raises(RequestRefused, match=words):
        open_world(world, more)


def test_invalid_requests_are_refused(world: Path) -> None:
    client = open_world(world, DOOR.replace("MORE", "kind: hinged") + LIFT)
    watch = wire.WatchDoor(id="w", door="front", least=0.8, most=0.2)
    placed = wire.SetEntityState(name="front", pose=pose(1.0, 1.0))
    cases: list[tuple[str, Callable[[], object]]] = [
        (
            "unknown door 'hoist'; doors: front",
            lambda: client.ask(wire.MOVE_DOOR, wire.MoveDoor(id="a", door="hoist", opening=1.0)),
        ),
        ("invalid opening 1.5 of a door; expected 0", lambda: move(client, 1.5)),
        ("expected the lower end first", lambda: client.ask(wire.WATCH_DOOR, watch)),
        (
            "unknown lift 'front'; lifts: hoist",
            lambda: client.ask(wire.MOVE_LIFT, wire.MoveLift(id="a", lift="front", floor=0)),
        ),
        (
            "unknown floor 2 of 'hoist'; expected 0 to 1",
            lambda: client.ask(wire.WATCH_LIFT, wire.WatchLift(id="a", lift="hoist", floor=2)),
        ),
        ("it is a door; move it by `move_door`", lambda: client.ask(wire.SET_ENTITY_STATE, placed)),
    ]
    for words, request in cases:
        with pytest.raises(RequestRefused, match=words):
            request()


@pytest.mark.parametrize("doors", ["closed", "automatic"])
def test_generated_rooms_have_doors(doors: str, world: Path) -> None:
    world.write_text(
        f"name: flat\ngenerate: {{rooms: {{count: 6, doors: {doors}, door: 0.9}}}}\n"
        "robots: [{name: turtlebot4, robot: turtlebot4, pose: {at: start}}]\n"
    )
    client = Client(str(world), 4)
    simulation = client.simulator.simulation
    found = [part for part in simulation.world.building if isinstance(part, Door)]
    marks = {pose.name: pose.place.planar for pose in simulation.world.poses if "door" in pose.tags}
    assert len(found) >= 5
    assert {door.name for door in found} == marks.keys()
    for door in found:
        assert marks[door.name].distance(*door.middle) < 1e-9
        assert (door.automatic is not None) == (doors == "automatic")
        client.ask(wire.MOVE_DOOR, wire.MoveDoor(id=door.name, door=door.name, opening=1.0))
    ended = {client.run_until(door.name)[0].outcome for door in found[-1:]}
    assert ended == {Outcome.SUCCEEDED}


def test_a_door_stands_on_the_floor_of_its_height(world: Path) -> None:
    client = open_world(world, DOOR.replace("MORE", "z: 0.5"))
    assert place(client, "front")[2] == pytest.approx(0.51)


@on_both
def test_the_force_of_a_door_limits_the_push_of_an_obstacle(world: Path, engine: str) -> None:
    crate = "props:\n  - {name: crate, box: [0.3, 0.3, 0.3], mass: 10, friction: 0.01, pose: {x: 0, y: -0.1}}\n"
    pushes = []
    for force in ("", ", force: 50"):
        client = open_world(world, DOOR.replace("MORE", f"kind: sliding, opening: 1{force}") + crate, engine)
        move(client, 0.0)
        fastest = 0.0
        for _ in range(150):
            advance(client, 0.02)
            fastest = max(fastest, -client.simulator.simulation.engine.body_state("crate").linear[1])
        pushes.append(10.0 * fastest)  # [N s]
    free, limited = pushes
    assert limited < 2 * 50.0 * 0.02 < 2.5 < free  # two ticks of the force at most
    assert opening(client) > 0.1
