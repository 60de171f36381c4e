"""Descriptions of worlds, to draw them."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from seoro.bridges import wire
from sim_nodes import scenery
from sim_nodes.__main__ import ENGINES
from sim_nodes.bodies import Hull, Part
from tests.sim_nodes.client import ROBOT, Client, pose

WORLD = """
name: shown
extent: [-3, -3, 3, 3]
walls:
  - {points: [[-2, 2], [2, 2]], thickness: 0.2, height: 1.0}
robots:
  - {name: tb, robot: turtlebot4}
props:
  - {name: post, cylinder: {radius: 0.1, length: 1.0}, pose: {x: 1.0, y: 1.0}}
  - {name: ball, sphere: 0.2, mass: 1.0, colour: [1.0, 0.0, 0.0], pose: {x: -1.0}}
poses:
  - {name: dock, pose: {x: 1.0, yaw: 1.5}}
"""


def scene_of(client: Client) -> wire.Scene:
    return client.ask(wire.GET_SCENE, wire.Empty())


@pytest.mark.parametrize("engine", ENGINES)
def test_a_world_is_described(tmp_path: Path, engine: str) -> None:
    (tmp_path / "shown.yaml").write_text(WORLD)
    scene = scene_of(Client(str(tmp_path / "shown.yaml"), engine=engine))
    shapes = {shape.entity: shape for shape in scene.shapes}
    assert (scene.world, scene.simulator, scene.extent) == ("shown", engine, (-3.0, -3.0, 3.0, 3.0))
    assert (shapes["walls"].kind, shapes["walls"].size[1:]) == ("box", (0.2, 1.0))
    assert (shapes["post"].kind, shapes["post"].pose[:3]) == ("cylinder", (1.0, 1.0, 0.5))
    entities = {entity.name: entity for entity in scene.entities}
    assert entities.keys() == {"tb", "ball"}
    assert (entities["tb"].kind, entities["tb"].model, len(entities["tb"].footprint)) == (
        "robot",
        "turtlebot4",
        24,
    )
    assert 0.2 < entities["tb"].height < 0.5
    [ball] = entities["ball"].shapes
    assert (ball.kind, ball.size, ball.color) == ("sphere", (0.2,), "#ff0000")
    assert [(place.name, place.pose) for place in scene.places] == [("dock", (1.0, 0.0, 1.5))]
    assert scene.map is not None
    assert len(scene.map.cells) == scene.map.columns * scene.map.rows
    assert scene.omitted == 0


def test_people_doors_and_spawned_bodies_have_kinds() -> None:
    client = Client("empty")
    client.ask(wire.SPAWN_PERSON, wire.SpawnPerson(name="guest", pose=pose(-2.0, 0.0)))
    client.spawn("box", pose(1.0, 0.5, z=0.2))
    kinds = {entity.name: entity.kind for entity in scene_of(client).entities}
    assert kinds == {ROBOT: "robot", "guest": "person", "box": "object"}


def hull(*points: tuple[float, float, float]) -> Part:
    return Part(Hull(b"".join(struct.pack("<3d", *point) for point in points)))


def test_hulls_have_few_corners_and_triangles_that_face_outwards() -> None:
    generator = np.random.default_rng(1)
    directions = generator.normal(size=(500, 3))
    ball = directions / np.linalg.norm(directions, axis=1)[:, None] * (1.0, 1.0, 3.0)
    shape = scenery.describe_part(hull(*map(tuple, ball.tolist())), (0.0, 0.0, 0.0, 1.0))
    corners = np.frombuffer(shape.corners, "<f4").reshape(-1, 3)
    triangles = np.frombuffer(shape.triangles, np.uint8).reshape(-1, 3)
    assert shape.kind == "hull"
    assert 14 <= len(corners) <= 26
    assert len(triangles) == 2 * len(corners) - 4  # a closed surface
    a, b, c = (corners[triangles[:, index]] for index in range(3))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0
    assert 0.7 * 4.0 * np.pi < volume < 4.0 * np.pi


def test_flat_hulls_are_prisms() -> None:
    flat = [(x, y, 1.0) for x, y in ((0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0), (1.0, 0.5))]
    shape = scenery.describe_part(hull(*flat), (0.0, 0.0, 0.0, 1.0))
    assert (shape.kind, shape.pose[2], shape.size) == ("polygon", 1.0, (0.0,))
    assert set(shape.points) == {(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)}


@pytest.mark.parametrize("engine", ENGINES)
def test_links_of_arms_have_poses_in_scenes_and_samples(engine: str) -> None:
    client = Client("arm_cell", engine=engine)
    [arm] = [entity for entity in scene_of(client).entities if entity.kind == "robot"]
    links = [link.name for link in arm.links]
    assert "forearm_link" in links
    assert {shape.link for shape in arm.shapes} == {"", *links}
    client.ask(wire.START_TRACKS, wire.StartTracks(rate=10.0))
    motion = wire.FollowJointTrajectory(
        id="move", robot=arm.name, joint_names=("wrist_1_joint",), points=((-1.0,),)
    )
    client.ask(wire.FOLLOW_JOINT_TRAJECTORY, motion)
    moved = [each for sample in client.advance(1.0).tracks for each in sample.moved_links]
    assert moved[0].links == tuple(links)
    assert len(moved) > 5
    assert "wrist_1_link" in moved[-1].links
    assert "upper_arm_link" not in moved[-1].links


def test_a_scene_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = scene_of(Client("maze"))
    monkeypatch.setattr(wire, "MAX_SHAPES", len(whole.shapes) - 2, raising=False)
    scene = scene_of(Client("maze"))
    assert len(scene.shapes) == len(whole.shapes) - 2
    assert [entity.shapes for entity in scene.entities] == [()]
    assert scene.omitted >= 3
