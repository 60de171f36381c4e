from __future__ import annotations

import math

import pytest

from seoro.bridges import wire
from seoro.bridges.wire import EntityName, Result, SpawnResult, Twist, Vector3
from seoro.bridges.wire.refusal import RequestRefused
from tests.sim_nodes.client import BOX, ROBOT, Client, pose

STATIC = BOX.replace('<link name="link">', '<static>true</static><link name="link">')


def names(client: Client, pattern: str = ".*") -> tuple[str, ...]:
    return client.ask(wire.GET_ENTITIES, wire.EntityFilter(filter=pattern)).names


def place(client: Client, name: str) -> tuple[float, float, float]:
    position = client.ask(wire.GET_ENTITY_STATE, EntityName(name=name)).pose.position
    return round(position.x, 3), round(position.y, 3), round(position.z, 3)


def test_entities_are_listed_sorted_and_filtered(maze: Client) -> None:
    maze.spawn("box", pose(2.0, -2.0))
    assert names(maze) == ("box", ROBOT, "walls")
    assert names(maze, "b.*") == ("box",)
    with pytest.raises(RequestRefused, match="invalid regular expression"):
        names(maze, "(")


def test_a_spawned_box_falls_and_stays(maze: Client) -> None:
    assert maze.spawn("box", pose(2.0, -2.0, 0.3, 0.1)) == "box"
    assert place(maze, "box") == (2.0, -2.0, 0.1)
    assert maze.advance(1.0).contacts == ()
    assert place(maze, "box") == pytest.approx((2.0, -2.0, 0.0), abs=2e-3)


def test_spawning_changes_nothing_else(maze: Client) -> None:
    other = Client("maze")
    for client in (maze, other):
        client.localise()
        client.navigate(pose(1.5, 1.5))
        client.advance(2.0)
    maze.spawn("box", pose(-4.5, -4.5))
    maze.ask(wire.DELETE_ENTITY, EntityName(name="box"))
    for client in (maze, other):
        client.advance(4.0)
    assert maze.truth == other.truth


def test_a_static_model_stays_where_it_is_spawned(maze: Client) -> None:
    maze.spawn("shelf", pose(2.0, -2.0, z=0.5), STATIC)
    maze.advance(0.5)
    assert place(maze, "shelf") == (2.0, -2.0, 0.5)
    maze.ask(wire.SET_ENTITY_STATE, wire.SetEntityState(name="shelf", pose=pose(3.0, -2.0, z=0.5)))
    maze.advance(0.6)
    assert place(maze, "shelf") == (3.0, -2.0, 0.5)


def test_names_in_use_are_refused_or_changed(maze: Client) -> None:
    maze.spawn("box", pose(2.0, -2.0))
    with pytest.raises(RequestRefused, match="in use: box, turtlebot4, walls") as refused:
        maze.spawn("box", pose(3.0, -3.0))
    assert refused.value.code == SpawnResult.NAME_NOT_UNIQUE
    assert maze.spawn("box", pose(3.0, -3.0), rename=True) == "box_1"


@pytest.mark.parametrize("name", ["", "a/b", "1st", "floor", "map", "x" * 65])
def test_invalid_names_are_refused(maze: Client, name: str) -> None:
    with pytest.raises(RequestRefused) as refused:
        maze.spawn(name, pose(2.0, -2.0))
    assert refused.value.code == SpawnResult.NAME_INVALID


@pytest.mark.parametrize(
    ("x", "y", "z", "words"),
    [
        (0.2, 0.1, 0.0, "would overlap turtlebot4"),
        (0.75, -2.0, 0.0, "would overlap walls"),
        (0.75, -2.0, 0.1, "would overlap walls"),
        (2.0, -2.0, -0.1, "0.100 m below the floor; expected z of 0.000 m or more"),
        (math.inf, 0.0, 0.0, "expected numbers within"),
    ],
)
@pytest.mark.parametrize("model", [BOX, STATIC], ids=["free", "static"])
def test_an_overlapping_pose_is_refused(
    maze: Client, x: float, y: float, z: float, words: str, model: str
) -> None:
    with pytest.raises(RequestRefused, match=words) as refused:
        maze.spawn("box", pose(x, y, z=z), model)
    assert refused.value.code == SpawnResult.INVALID_POSE
    assert "box" not in names(maze)


def test_an_invalid_model_is_refused_with_its_name(maze: Client) -> None:
    with pytest.raises(RequestRefused, match=r"box.sdf: .*invalid XML") as refused:
        maze.spawn("box", pose(2.0, -2.0), "nonsense")
    assert refused.value.code == SpawnResult.RESOURCE_PARSE_ERROR
    with pytest.raises(RequestRefused) as refused:
        maze.spawn("box", pose(2.0, -2.0), " ")
    assert refused.value.code == SpawnResult.NO_RESOURCE


def test_only_spawned_entities_can_be_deleted(maze: Client) -> None:
    maze.spawn("box", pose(2.0, -2.0))
    maze.ask(wire.DELETE_ENTITY, EntityName(name="box"))
    assert "box" not in names(maze)
    for name, code in (
        ("box", Result.NOT_FOUND),
        (ROBOT, Result.OPERATION_FAILED),
        ("walls", Result.OPERATION_FAILED),
    ):
        with pytest.raises(RequestRefused) as refused:
            maze.ask(wire.DELETE_ENTITY, EntityName(name=name))
        assert refused.value.code == code
    maze.spawn("box", pose(2.0, -2.0))


def test_entities_can_be_moved(maze: Client) -> None:
    maze.spawn("box", pose(2.0, -2.0))
    maze.ask(wire.SET_ENTITY_STATE, wire.SetEntityState(name=ROBOT, pose=pose(1.5, 1.5, 1.0)))
    assert maze.truth == pytest.approx((1.5, 1.5, 1.0))
    push = Twist(linear=Vector3(x=0.5))
    maze.ask(wire.SET_ENTITY_STATE, wire.SetEntityState(name="box", twist=push))
    assert maze.ask(wire.GET_ENTITY_STATE, EntityName(name="box")).twist.linear.x == pytest.approx(0.5)
    assert place(maze, "box") == (2.0, -2.0, 0.0)


def test_entities_cannot_be_moved_into_others(maze: Client) -> None:
    for at, words in ((pose(0.75, -2.0), "overlap walls"), (pose(2.0, -2.0), "overlap box")):
        if "box" not in names(maze):
            maze.spawn("box", pose(2.0, -2.0))
        with pytest.raises(RequestRefused, match=words):
            maze.ask(wire.SET_ENTITY_STATE, wire.SetEntityState(name=ROBOT, pose=at))
        assert maze.truth.distance(0.0, 0.0) < 1e-3
    with pytest.raises(RequestRefused, match="cannot be moved: it is a wall") as refused:
        maze.ask(wire.SET_ENTITY_STATE, wire.SetEntityState(name="walls", pose=pose(0.0, 0.0)))
    assert refused.value.code == Result.FEATURE_UNSUPPORTED
