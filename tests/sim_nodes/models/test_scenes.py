"""Files with several bodies: split into bodies that both engines simulate."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from seoro.bridges import wire
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.__main__ import ENGINES
from sim_nodes.check.bench import run, scene
from sim_nodes.models.scenes import SceneBody, split_scene
from sim_nodes.physics import Box, Engine
from sim_nodes.worlds.loader import parse_world
from tests.sim_nodes.client import Client, pose
from tests.sim_nodes.engines import make_engine

KITCHEN = """<mujoco model="kitchen"><compiler autolimits="true"/>
<asset><mesh name="wedge" vertex="0 0 0 0.1 0 0 0 0.1 0 0 0 0.1"/><material name="red" rgba="1 0 0 1"/></asset>
<worldbody>
<geom type="plane" size="5 5 1"/><light pos="0 0 3"/>
<camera name="look" mode="targetbody" target="cup" pos="0 0 2"/>
<body name="table" pos="1 0 0.2"><geom type="box" size="0.3 0.3 0.2"/></body>
<body name="door" pos="0 1 0.5" euler="0 0 90">
  <joint name="hinge" axis="0 0 1" range="-90 90"/><geom type="box" size="0.4 0.02 0.4" pos="0.4 0 0"/></body>
<body name="left" pos="0 -1 0.2"><joint name="l" type="slide" axis="1 0 0"/><geom size="0.05"/></body>
<body name="right" pos="0 -2 0.2"><joint name="r" type="slide" axis="1 0 0"/><geom size="0.05"/></body>
<frame pos="1 0 0"><body name="cup" pos="0 0 0.46" euler="0 0 30"><freejoint/>
  <geom type="mesh" mesh="wedge" material="red"/></body></frame>
<body name="2nd cup" pos="1 0.2 0.5"><freejoint/><geom type="box" size="0.05 0.05 0.05"/></body>
<body name="goal" mocap="true" pos="2 2 0"><site name="there"/></body>
</worldbody>
<equality><joint joint1="l" joint2="r"/><weld body1="cup" body2="goal"/></equality>
<actuator><position joint="hinge" kp="1"/></actuator>
<keyframe><key qpos="0 0 0 1 0 0.46 1 0 0 0 1 0.2 0.5 1 0 0 0"/></keyframe></mujoco>"""
SHELF = """<sdf version="1.9"><world name="w"><light name="sun" type="directional"/>
<model name="ground_plane"><static>true</static><link name="l">
  <collision name="c"><geometry><plane><normal>0 0 1</normal></plane></geometry></collision></link></model>
<model name="shelf"><static>true</static><pose>1 0 0.2 0 0 0</pose><link name="l"><collision name="c"><geometry>
  <box><size>0.6 0.6 0.4</size></box></geometry></collision></link></model>
<model name="pair"><pose>1 0 0.5 0 0 0</pose>
  <link name="a"><collision name="c"><geometry><box><size>0.1 0.1 0.1</size></box></geometry></collision></link>
  <link name="b"><pose>0.2 0 0 0 0 0</pose>
  <collision name="c"><geometry><box><size>0.1 0.1 0.1</size></box></geometry></collision></link></model>
<include><uri>model://crate</uri><pose>0 2 0.5 0 0 0</pose></include>
<include><uri>model://crate</uri><name>crate</name><pose>0 3 0.5 0 0 0</pose><static>true</static></include>
</world></sdf>"""
CRATE = b"""<sdf version="1.9"><model name="crate"><pose>9 9 9 0 0 0</pose><link name="l">
<inertial><mass>2</mass></inertial>
<collision name="c"><geometry><box><size>0.2 0.2 0.2</size></box></geometry></collision></link></model></sdf>"""


def added(engine: str, bodies: tuple[SceneBody, ...]) -> Engine:
    made = make_engine(engine)
    made.build(scene())
    for body in bodies:
        made.add_body(body.name, body.model, body.state)
    return made


def test_what_moves_in_mjcf_is_a_body_of_its_own() -> None:
    bodies = {body.name: body for body in split_scene(KITCHEN, {})}
    assert set(bodies) == {"scene", "door", "left", "cup", "body_2nd_cup"}
    assert [name for name, body in bodies.items() if body.model.static] == ["scene", "door", "left"]
    assert [part.shape for part in bodies["scene"].model.parts] == [Box((0.6, 0.6, 0.4))]
    joints = {name: body.model.urdf.joints for name, body in bodies.items() if body.model.urdf is not None}
    assert joints == {"scene": (), "door": ("hinge",), "left": ("l", "r"), "cup": (), "body_2nd_cup": ()}
    door, cup = bodies["door"].state, bodies["cup"].state
    assert door.position == (0.0, 1.0, 0.5)
    assert door.orientation == pytest.approx((0.5**0.5, 0.0, 0.0, 0.5**0.5))
    assert cup.position == pytest.approx((1.0, 0.0, 0.46))
    assert bodies["scene"].model.notes == (
        "without effect: 1 equalities or tendons between bodies that move apart",
    )


def test_parts_of_a_scene_have_only_the_meshes_they_need() -> None:
    bodies = {body.name: body.model.mjcf for body in split_scene(KITCHEN, {})}
    named = {name: "wedge" in model.text for name, model in bodies.items() if model is not None}
    assert named == {"scene": False, "door": False, "left": False, "cup": True, "body_2nd_cup": False}


def test_models_and_loose_links_in_sdf_are_bodies() -> None:
    bodies = split_scene(SHELF, {"model/crate/model.sdf": CRATE})
    assert {body.name: (body.model.static, body.state.position) for body in bodies} == {
        "shelf": (True, (1.0, 0.0, 0.2)),
        "crate_2": (True, (0.0, 3.0, 0.5)),
        "pair_a": (False, (1.0, 0.0, 0.5)),
        "pair_b": (False, (1.2, 0.0, 0.5)),
        "crate": (False, (0.0, 2.0, 0.5)),
    }
    assert all(body.model.parts[0].position == pytest.approx((0.0, 0.0, 0.0)) for body in bodies)


def test_a_file_with_a_floor_only_has_no_bodies() -> None:
    assert split_scene('<mujoco><worldbody><geom type="plane" size="1 1 1"/></worldbody></mujoco>', {}) == ()


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    ("text", "on_top", "height"), [(KITCHEN, "body_2nd_cup", 0.45), (SHELF, "pair_b", 0.45)], ids=["mjcf", "sdf"]
)
def test_bodies_of_a_scene_rest_on_each_other(engine: str, text: str, on_top: str, height: float) -> None:
    made = added(engine, split_scene(text, {"model/crate/model.sdf": CRATE}))
    run(made, 1.0)
    state = made.body_state(on_top)
    assert state.position[2] == pytest.approx(height, abs=2e-3)
    assert np.abs(state.linear).max() < 0.01


def test_too_many_bodies_are_refused() -> None:
    models = "".join(f"<model name='m{index}'/>" for index in range(201))
    with pytest.raises(RequestRefused, match="found 201 models in the file; expected at most 200"):
        split_scene(f"<sdf><world name='w'>{models}</world></sdf>", {})
    balls = '<body><freejoint/><geom size="0.1"/></body>' * 201
    with pytest.raises(RequestRefused, match="found 201 bodies in the file that move; expected at most 200"):
        split_scene(f"<mujoco><worldbody>{balls}</worldbody></mujoco>", {})


@pytest.mark.parametrize("engine", ENGINES)
def test_a_scene_is_spawned_as_several_entities_and_deleted_with_the_first(engine: str) -> None:
    client = Client("empty", engine=engine)
    client.spawn("box", pose(3.0, 3.0))
    request = wire.SpawnEntity(
        name="box", uri="", resource_string=KITCHEN, initial_pose=pose(2.0, 1.0, 1.57), allow_renaming=True
    )
    spawned = client.ask(wire.SPAWN_ENTITY, request)
    assert spawned.name == "box_1"
    assert spawned.warnings[-1] == "spawned with it: box_1_body_2nd_cup, box_1_cup"
    client.advance(1.0)
    cup = client.ask(wire.GET_ENTITY_STATE, wire.EntityName(name="box_1_body_2nd_cup")).pose.position
    assert (cup.x, cup.y, cup.z) == pytest.approx((1.8, 2.0, 0.45), abs=5e-3)
    client.ask(wire.DELETE_ENTITY, wire.EntityName(name="box_1"))
    assert client.ask(wire.GET_ENTITIES, wire.EntityFilter(filter="box.*")).names == ("box",)


def test_a_scene_that_overlaps_something_is_refused_as_a_whole() -> None:
    client = Client("empty")
    client.spawn("box", pose(1.0, 0.35, z=0.5))
    with pytest.raises(RequestRefused, match="'kitchen_body_2nd_cup' would overlap box"):
        client.spawn("kitchen", pose(0.0, 0.0), KITCHEN)
    assert client.ask(wire.GET_ENTITIES, wire.EntityFilter(filter=".*box|kitchen.*")).names == ("box",)


def test_a_prop_may_be_a_scene(tmp_path: Path) -> None:
    (tmp_path / "kitchen.xml").write_text(KITCHEN)
    text = "name: w\nextent: [-4, -4, 4, 4]\nprops:\n- {name: a, model: kitchen.xml, pose: {x: 1.0, y: 0.0}}\n"
    world = parse_world(text + "- {name: a_cup, cube: 0.1, pose: {x: -3.0, y: 0.0}}\n", "w", tmp_path)
    assert [prop.name for prop in world.props] == ["a", "a_cup_1", "a_body_2nd_cup", "a_cup"]
    assert world.props[1].state.position == pytest.approx((2.0, 0.0, 0.46))
    assert [note for note in world.warnings if "equalities" in note] == [
        "props.0: without effect: 1 equalities or tendons between bodies that move apart"
    ]
