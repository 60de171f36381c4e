from __future__ import annotations

import numpy as np
import pytest

from seoro.bridges.wire import SpawnResult
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.__main__ import ENGINES
from sim_nodes.extents import inertia
from sim_nodes.geometry import quaternion
from sim_nodes.models import parse_model
from sim_nodes.physics import Box, Cylinder, Sphere
from tests.sim_nodes.client import Client, pose

MASS = '<inertial><mass value="2"/></inertial>'
BALL = '<collision><geometry><sphere radius="0.1"/></geometry></collision>'
# A stand of 1 kg with a rod of 3 kg across on top, which is turned and hangs on a frame without mass.
STAND = """
<robot name="stand">
  <link name="foot">
    <inertial><origin xyz="0 0 0.2"/><mass value="1"/><inertia ixx="9" iyy="9" izz="9"/></inertial>
    <visual><geometry><mesh filename="pretty.dae"/></geometry><material name="red"/></visual>
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


def joint(parent: str, child: str, kind: str = "fixed") -> str:
    return f'<joint name="j" type="{kind}"><parent link="{parent}"/><child link="{child}"/></joint>'


def test_links_at_fixed_joints_are_one_body() -> None:
    model = parse_model(STAND)
    foot, rod = model.parts
    assert (foot.shape, rod.shape) == (Box((0.2, 0.3, 0.4)), Cylinder(0.05, 0.6))
    assert rod.position == pytest.approx((0.1, 0.2, 0.45))
    assert rod.orientation == pytest.approx(quaternion(0.0, np.pi / 2, 0.0))
    assert (model.mass, foot.mass, rod.mass, model.static) == (4.0, 1.0, 3.0, False)


def test_the_first_visual_defines_the_colour() -> None:
    assert parse_model(STAND).colour == (0.8, 0.1, 0.1, 1.0)


def test_masses_are_read_by_link() -> None:
    assert inertia(parse_model(STAND)).centre == pytest.approx((0.075, 0.15, (0.2 + 3 * 0.45) / 4))


def test_shape_poses_match_those_of_mujoco() -> None:
    mujoco = pytest.importorskip("mujoco")
    text = STAND.replace(
        '<visual><geometry><mesh filename="pretty.dae"/></geometry><material name="red"/></visual>', ""
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
    model = parse_model(urdf(link(BALL)), static=True)
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
        (urdf(link(MASS + BALL), "<gazebo/>"), "<gazebo>"),
        (urdf(link(MASS + BALL), "<transmission/>"), "<transmission>"),
        (urdf(link(MASS + BALL), link(MASS + BALL, "k"), joint("l", "k", "revolute")), "'revolute'"),
        (urdf(link(MASS + BALL), link(MASS + BALL, "k")), "found 2 root links"),
        (urdf(link(MASS + BALL), link(MASS + BALL)), "missing or duplicate name"),
        (urdf(link(MASS + BALL), joint("l", "m")), "unknown child link 'm'"),
        (urdf(link(BALL), link(BALL, "k"), joint("l", "k"), joint("k", "l")), "found 0 root links"),
        (urdf(link(""), link("", "k"), link("", "m"), joint("k", "m"), joint("m", "k")), "is its own ancestor"),
        (urdf(link(BALL)), "no <inertial>"),
        (urdf(link(MASS)), "no <collision>"),
        (urdf(link("")), "found 0 collision shapes"),
        (urdf(link("<inertial/>" + BALL)), "invalid mass of <link name='l'>: ''"),
        (urdf(link('<inertial><mass value="nan"/></inertial>' + BALL)), "0.001 to 10000"),
        (urdf(link('<inertial><origin xyz="1 0 0"/><mass value="1"/></inertial>' + BALL)), "centre of mass"),
        (urdf(link(MASS + BALL.replace("sphere", "capsule"))), "<capsule>"),
        (urdf(link(MASS + BALL.replace('radius="0.1"', 'radius="0"'))), "0.01 to 20"),
        (urdf(link(MASS + '<collision><origin xyz="1 2"/></collision>')), "3 numbers"),
        (urdf(link(MASS + "<collision/>")), "with one shape"),
        (urdf(link(MASS + BALL * 65)), "found 65 collision shapes"),
    ],
)
def test_unsupported_elements_are_refused_by_name(text: str, words: str) -> None:
    with pytest.raises(RequestRefused, match=words) as refused:
        parse_model(text)
    assert refused.value.code == SpawnResult.RESOURCE_PARSE_ERROR


def test_collision_meshes_are_refused() -> None:
    mesh = '<collision><geometry><mesh filename="a.stl"/></geometry></collision>'
    with pytest.raises(RequestRefused, match="mesh") as refused:
        parse_model(urdf(link(MASS + mesh)))
    assert refused.value.code == SpawnResult.UNSUPPORTED_ASSETS
