from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from defusedxml import ElementTree

from seoro.bridges.wire import SpawnResult
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.__main__ import ENGINES
from sim_nodes.extents import bounding_box
from sim_nodes.geometry import quaternion
from sim_nodes.models import parse_model
from sim_nodes.models.settings import ModelSettings
from sim_nodes.physics import BodyModel, Box, Cylinder, Sphere
from tests.sim_nodes.client import Client, pose

MASS = '<inertial><mass value="2"/></inertial>'
MESH = '<collision><geometry><mesh filename="a.stl"/></geometry></collision>'
BALL = '<collision><geometry><sphere radius="0.1"/></geometry></collision>'
# A stand of 1 kg with a rod of 3 kg across on top, which is turned and hangs on a frame without mass.
STAND = """
<robot name="stand">
  <link name="foot">
    <inertial><origin xyz="0 0 0.2"/><mass value="1"/><inertia ixx="9" iyy="9" izz="9"/></inertial>
    <visual><geometry><box size="0.2 0.3 0.4"/></geometry><material name="red"/></visual>
    <collision><origin xyz="0 0 0.2"/><geometry><box size="0.2 0.3 0.4"/></geometry></collision>
  </link>
  <material name="red"><color rgba="0.8 0.1 0.1 0.5"/></material>
  <link name="top"/>
  <link name="rod">
    <inertial><mass value="3"/></inertial>
    <collision><geometry><cylinder radius="0.05" length="0.6"/></geometry></collision>
  </link>
  <joint name="a" type="fixed"><parent link="foot"/><child link="top"/><origin xyz="0.1 0 0.45"/></joint>
  <joint name="b" type="fixed">
    <parent link="top"/><child link="rod"/><origin xyz="0 0.2 0" rpy="0 1.5707963267948966 0"/>
  </joint>
</robot>
"""


def urdf(*parts: str) -> str:
    return f'<robot name="r">{"".join(parts)}</robot>'


def link(content: str, name: str = "l") -> str:
    return f'<link name="{name}">{content}</link>'


def read_urdf(model: BodyModel) -> Any:
    assert model.urdf is not None
    return ElementTree.fromstring(model.urdf.text)


def joint(parent: str, child: str, kind: str = "fixed") -> str:
    return f'<joint name="j" type="{kind}"><parent link="{parent}"/><child link="{child}"/></joint>'


def test_links_at_fixed_joints_are_one_body() -> None:
    model = parse_model(STAND)
    foot, rod = model.parts
    assert (foot.shape, rod.shape) == (Box((0.2, 0.3, 0.4)), Cylinder(0.05, 0.6))
    assert rod.position == pytest.approx((0.1, 0.2, 0.45))
    assert rod.orientation == pytest.approx(quaternion(0.0, np.pi / 2, 0.0))
    assert model.mass == pytest.approx(4.001)  # with a gram for the frame
    assert not model.static


def test_the_first_visual_defines_the_colour() -> None:
    assert parse_model(STAND).colour == (0.8, 0.1, 0.1, 0.5)


def test_impossible_inertia_is_computed_from_the_shapes_with_a_note() -> None:
    text = urdf(link('<inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="9"/></inertial>' + BALL))
    model = parse_model(text)
    assert "no body can have the inertia of link 'l'" in "; ".join(model.notes)
    moments = [float(read_urdf(model).find("link/inertial/inertia").get(key)) for key in ("ixx", "iyy", "izz")]
    assert moments == pytest.approx(3 * [0.4 * 2.0 * 0.01])


def test_links_without_a_mass_have_one_by_volume_with_a_note() -> None:
    model = parse_model(urdf(link(BALL)))
    assert model.mass == pytest.approx(1000.0 * 4 / 3 * np.pi * 0.001)
    assert "by its volume" in "; ".join(model.notes)


def test_elements_without_effect_are_one_note() -> None:
    contact = '<contact><lateral_friction value="0.3"/><stiffness value="1"/></contact>'
    model = parse_model(urdf(link(MASS + BALL + contact), "<gazebo/>", "<transmission/>"))
    assert model.notes == ("without effect: <gazebo>, <stiffness>, <transmission>",)
    assert model.urdf is not None
    assert model.urdf.friction == {"l": 0.3}


def test_a_root_link_without_mass_value_is_static() -> None:
    assert parse_model(urdf(link('<inertial><mass value="0"/></inertial>' + BALL))).static
    world = urdf(link("", "world"), link(MASS + BALL), joint("world", "l"))
    assert parse_model(world).static
    assert not parse_model(world.replace("world", "base")).static


def test_joints_keep_their_kinds_and_limits() -> None:
    text = urdf(
        link(MASS + BALL),
        link(MASS + BALL, "k"),
        joint("l", "k", "revolute").replace("/></joint>", '/><limit lower="-1" upper="2" effort="5"/></joint>'),
    )
    model = parse_model(text)
    assert model.urdf is not None
    assert model.urdf.joints == ("j",)
    limit = read_urdf(model).find("joint/limit")
    assert [limit.get(key) for key in ("lower", "upper", "effort")] == ["-1.0", "2.0", "5.0"]


def test_shape_poses_match_those_of_mujoco() -> None:
    mujoco = pytest.importorskip("mujoco")
    text = STAND.replace(
        '<visual><geometry><box size="0.2 0.3 0.4"/></geometry><material name="red"/></visual>', ""
    )
    text = text.replace('<inertia ixx="9" iyy="9" izz="9"/>', "")
    text = text.replace("<inertial>", '<inertial><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>')
    free = mujoco.MjSpec.from_string(text)
    world = free.compile()
    data = mujoco.MjData(world)
    mujoco.mj_forward(world, data)
    own = parse_model(STAND)
    # MuJoCo welds the first link to the world and keeps the geoms of all.
    positions = sorted(map(tuple, np.round(data.geom_xpos, 9).tolist()))
    assert positions == sorted(tuple(round(value, 9) for value in part.position) for part in own.parts)


def test_static_bodies_need_no_mass() -> None:
    model = parse_model(urdf(link(BALL)), settings=ModelSettings(static=True))
    assert model.static
    assert model.parts[0].shape == Sphere(0.1)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_body_with_a_foot_stands(engine: str) -> None:
    client = Client("empty", engine=engine)
    client.spawn("stand", pose(2.0, 1.0, z=0.05), STAND.replace('value="3"', 'value="0.1"'))
    client.advance(2.0)
    assert client.simulator.simulation.engine.body_state("stand").position == pytest.approx((2, 1, 0), abs=5e-3)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_body_with_its_mass_beside_its_foot_tips_over(engine: str) -> None:
    client = Client("empty", engine=engine)
    client.spawn("stand", pose(2.0, 1.0, z=0.001), STAND.replace('value="3"', 'value="30"'))
    client.advance(2.0)
    up = client.simulator.simulation.engine.body_state("stand").orientation
    assert abs(up[0]) < 0.95


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (urdf(link(MASS + BALL), link(MASS + BALL, "k"), joint("l", "k", "screw")), "unknown type 'screw'"),
        (urdf(link(MASS + BALL), link(MASS + BALL, "k")), "found 2 root links in the model: k, l"),
        (urdf(link(MASS + BALL), link(MASS + BALL)), "missing or duplicate name"),
        (urdf(link(MASS + BALL), joint("l", "m")), "unknown child link 'm'"),
        (urdf(link(BALL), link(BALL, "k"), joint("l", "k"), joint("k", "l")), "found 0 root links"),
        (urdf(link(""), link("", "k"), link("", "m"), joint("k", "m"), joint("m", "k")), "is its own ancestor"),
        (urdf(link(MASS)), "no shapes in the model"),
        (
            '<robot name="r" xmlns:x="http://www.ros.org/wiki/xacro"><x:macro name="m"/></robot>',
            "found macros of xacro in the model; expected a file with the suffix .xacro",
        ),
        (urdf(link('<inertial><mass value=""/></inertial>' + BALL)), "invalid mass of <link name='l'>: ''"),
        (urdf(link('<inertial><mass value="nan"/></inertial>' + BALL)), "0 to 100000"),
        (urdf(link(MASS + BALL.replace("sphere", "cone"))), "unsupported <cone>"),
        (urdf(link(MASS + BALL.replace('radius="0.1"', 'radius="-1"'))), "0 to 10000"),
        (urdf(link(MASS + BALL.replace("<collision>", '<collision><origin xyz="1 2"/>'))), "3 numbers"),
        (urdf(link(MASS + BALL * 1001)), "more than 1000 shapes"),
        (urdf(link(MASS + MESH)), "missing mesh 'a.stl'"),
        (urdf(link(MASS + MESH.replace("stl", "step"))), "unsupported format of the mesh 'a.step'"),
    ],
)
def test_invalid_models_are_refused_with_the_place(text: str, words: str) -> None:
    with pytest.raises(RequestRefused, match=words) as refused:
        parse_model(text)
    assert refused.value.code == SpawnResult.RESOURCE_PARSE_ERROR


@pytest.mark.parametrize("data", [b"", b"solid\nendsolid", bytes(84), b"\x00\xff" * 100])
def test_damaged_meshes_are_refused(data: bytes) -> None:
    with pytest.raises(RequestRefused, match=r"the mesh 'a\.stl' (is damaged|has no triangles)"):
        parse_model(urdf(link(MASS + MESH)), {"a.stl": data})


DAE = """<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="0.01" name="centimeter"/><up_axis>{up}</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="s"><float_array id="f" count="12">0 0 0 10 0 0 0 20 0 0 0 30</float_array>
<technique_common><accessor source="#f" count="4" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/><p>0 2 1 0 1 3 0 3 2 1 2 3</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="w"><node><instance_geometry url="#g"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#w"/></scene></COLLADA>"""


@pytest.mark.parametrize("up", ["Y_UP", "Z_UP"])
def test_coordinates_of_dae_are_those_of_the_file_in_its_unit(up: str) -> None:
    text = urdf(link(MASS + '<collision><geometry><mesh filename="a.dae"/></geometry></collision>'))
    box = bounding_box(parse_model(text, {"a.dae": DAE.format(up=up).encode()}).parts)
    assert box is not None
    assert box.upper == pytest.approx([0.1, 0.2, 0.3])
