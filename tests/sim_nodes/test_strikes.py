"""Strikers of contacts, the same in both engines."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.bridges import wire
from seoro.bridges.wire import Twist, Vector3
from tests.sim_nodes.client import ROBOT, Client, pose
from tests.sim_nodes.manipulation.cell import ARM, Cell, box, down

OTHER = "second"
PARCEL = "<mass>3.0<"
WORLD = """
name: pair
extent: [-5, -5, 5, 5]
walls:
  - {name: barrier, points: [[3, -2], [3, 2]]}
robots:
  - {name: turtlebot4, robot: turtlebot4}
  - {name: second, robot: turtlebot4, pose: {x: -2.0}}
"""


@pytest.fixture(params=["mujoco", "pybullet"])
def pair(tmp_path: Path, request: pytest.FixtureRequest) -> Client:
    """Return a client of two robots facing along x, the second 2 m behind the first, and a wall 3 m ahead."""
    path = tmp_path / "pair.yaml"
    path.write_text(WORLD)
    return Client(str(path), engine=request.param)


def drive(client: Client, robot: str, linear: float, duration: float = 10.0) -> None:
    goal = f"{robot}-{client.simulator.simulation.time}"
    client.ask(wire.DRIVE, wire.Drive(id=goal, robot=robot, linear=linear, angular=0.0, duration=duration))


def put(client: Client, name: str, at: wire.Pose3D, ahead: float = 0.0, aside: float = 0.0) -> None:
    twist = Twist(linear=Vector3(x=ahead, y=aside))
    client.ask(wire.SET_ENTITY_STATE, wire.SetEntityState(name=name, pose=at, twist=twist))


def cube(edge: float = 0.3) -> str:
    return box(edge, edge, edge).replace("<mass>0.2<", PARCEL)


def contacts(client: Client, until: float, step: float = 20.0) -> list[wire.Contact]:
    """Return all contacts up to a time, in grants of a maximum length."""
    found: list[wire.Contact] = []
    while (now := client.simulator.simulation.time) < until:
        found += client.advance(min(now + step, until)).contacts
    return found


def strikers(found: list[wire.Contact], *names: str) -> list[tuple[str, ...] | None]:
    return [contact.strikers for contact in found if {contact.first, contact.second} == set(names)]


def test_a_robot_that_drives_into_a_standing_one_is_the_striker(pair: Client) -> None:
    pair.spawn("box", pose(1.0, 0.0, z=0.15), cube())
    drive(pair, ROBOT, 0.2, 4.0)
    [contact] = contacts(pair, 4.0)
    assert contact.strikers == (ROBOT,)
    assert contact.position is not None
    assert (contact.position.x, contact.position.y) == pytest.approx((0.85, 0.0), abs=0.1)
    assert not contact.pushes


def test_a_standing_robot_is_not_the_striker(pair: Client) -> None:
    pair.spawn("box", pose(0.4, 0.0, z=0.151), cube())
    put(pair, "box", pose(0.4, 0.0, z=0.151), ahead=-2.0)
    assert strikers(contacts(pair, 1.0), "box", ROBOT)[0] == ("box",)


def test_a_robot_hit_from_behind_is_not_the_striker(pair: Client) -> None:
    pair.spawn("box", pose(-0.6, 0.0, z=0.151), cube())
    drive(pair, ROBOT, 0.1)
    contacts(pair, 1.0)
    put(pair, "box", pose(-0.5, 0.0, z=0.151), ahead=3.0)
    assert strikers(contacts(pair, 2.0), "box", ROBOT)[0] == ("box",)


def test_a_robot_hit_from_the_side_is_not_the_striker(pair: Client) -> None:
    drive(pair, ROBOT, 0.3)
    contacts(pair, 1.0)
    x = pair.truth.x
    pair.spawn("box", pose(x + 0.1, 0.6, z=0.151), cube())
    put(pair, "box", pose(x + 0.1, 0.6, z=0.151), aside=-3.0)
    assert strikers(contacts(pair, 1.5), "box", ROBOT)[0] == ("box",)


def test_robots_that_drive_into_each_other_are_both_strikers(pair: Client) -> None:
    drive(pair, OTHER, 0.2)
    drive(pair, ROBOT, -0.2)
    [contact] = contacts(pair, 5.0)
    assert set(contact.strikers or ()) == {ROBOT, OTHER}


def test_a_robot_pushed_into_a_body_is_not_the_striker(pair: Client) -> None:
    pair.spawn("box", pose(0.5, 0.0, z=0.15), box(0.3, 0.3, 0.3, static=True))
    drive(pair, OTHER, 0.3, 12.0)
    found = contacts(pair, 12.0)
    assert strikers(found, OTHER, ROBOT)[0] == (OTHER,)
    assert not any(ROBOT in (contact.strikers or ()) for contact in found)
    assert strikers(found, ROBOT, "box"), "it was pushed as far as that"


def test_a_body_placed_in_front_of_a_robot_is_the_striker(pair: Client) -> None:
    pair.spawn("box", pose(0.0, 2.0, z=0.15), box(0.3, 0.3, 0.3, static=True))
    drive(pair, ROBOT, 0.3)
    contacts(pair, 2.0)
    ahead = pair.truth.x + 0.15 + 0.1665  # the base reaches 0.164 m ahead
    put(pair, "box", pose(ahead, 0.0, z=0.15))
    placed = pair.simulator.simulation.time
    [contact] = contacts(pair, 2.2)
    assert contact.time - placed <= 0.02
    assert contact.strikers == ("box",)
    [contact] = contacts(pair, 3.0)
    assert (contact.strikers, contact.pushes) == ((ROBOT,), True), "it has had the time to stop"


def test_a_robot_that_keeps_pushing_is_a_striker_again(pair: Client) -> None:
    drive(pair, ROBOT, 0.3, 10.5)
    assert strikers(contacts(pair, 11.0), "barrier", ROBOT)[0] == (ROBOT,)
    drive(pair, ROBOT, 0.3, 1.0)
    *_, again = contacts(pair, 12.5)
    assert (again.strikers, again.pushes) == ((ROBOT,), True)
    drive(pair, ROBOT, -0.3, 1.0)
    assert not any(contact.pushes for contact in contacts(pair, 14.0)), "it backs off"


@pytest.mark.more
def test_the_size_of_grants_does_not_change_strikers(pair: Client) -> None:
    found = []
    for step in (20.0, 0.02, 0.037):
        pair.ask(wire.RESET_SIMULATION, wire.ResetSimulation())
        pair.spawn("box", pose(0.6, 0.05, z=0.15), cube())
        drive(pair, ROBOT, 0.2)
        drive(pair, OTHER, 0.3)
        found.append(contacts(pair, 12.0, step))
    assert found[0]
    assert found[0] == found[1] == found[2]


def test_a_restored_run_has_the_same_strikers(pair: Client) -> None:
    pair.spawn("box", pose(0.6, 0.05, z=0.15), cube())
    drive(pair, ROBOT, 0.2)
    contacts(pair, 1.313)
    snapshot = pair.ask(wire.SAVE_STATE, wire.Empty())
    first = contacts(pair, 6.0)
    request = wire.RestoreState(snapshot=snapshot, purpose=wire.Purpose.CONTINUE, seed=None)
    pair.ask(wire.RESTORE_STATE, request)
    assert first
    assert contacts(pair, 6.0) == first


@pytest.mark.parametrize("engine", ["mujoco", "pybullet"])
def test_an_arm_is_the_striker_of_collisions_of_its_load_only(engine: str) -> None:
    cell = Cell(engine)
    seen: list[wire.Contact] = []
    finish = cell.run_until

    def recorded(goal: str, limit: float = 60.0) -> tuple[wire.Occurrence, list[wire.Contact]]:
        ended, found = finish(goal, limit)
        seen.extend(found)
        return ended, found

    cell.run_until = recorded  # type: ignore[method-assign,assignment]
    cell.place("cube", 0.65, 0.1, 0.025)
    cell.pick("cube", 0.65, 0.1, 0.0)
    assert strikers(seen, ARM, "cube")[0] == (ARM,), "its fingers close on the cube"
    seen.clear()
    cell.move(down(0.65, 0.1, 0.03), straight=True)
    assert not any(contact.strikers for contact in seen), "it sets the cube down"
    cell.grip(0.085)
    cell.move(down(0.65, 0.1, 0.18), straight=True)
    assert not any(contact.strikers for contact in seen), "it leaves the cube alone"
    cell.pick("cube", 0.65, 0.1, 0.0)
    seen.clear()
    cell.spawn("post", pose(0.65, -0.05, z=0.7 + 0.15), box(0.1, 0.1, 0.3, static=True))
    cell.start_tool(down(0.65, -0.1, 0.18), may_touch=("post",), max_velocity_scaling_factor=0.3)
    cell.end()
    [contact, *_] = [contact for contact in seen if "post" in (contact.first, contact.second)]
    assert contact.strikers == (ARM,)
    assert contact.held == ({"cube": ARM} if "cube" in (contact.first, contact.second) else {})


def test_robots_of_simulators_sense_contacts(pair: Client) -> None:
    features = pair.ask(wire.GET_SIMULATOR_FEATURES, wire.Empty())
    assert all(robot.senses_contacts for robot in features.robots)
