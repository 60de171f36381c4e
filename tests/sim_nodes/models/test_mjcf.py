from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from defusedxml import ElementTree

from seoro.bridges.wire import SpawnResult
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.__main__ import ENGINES
from sim_nodes.geometry import rotation_matrix
from sim_nodes.models import parse_model
from sim_nodes.models.meshes import Mesh, to_stl
from sim_nodes.physics import Box, Cylinder, Hull, Sphere
from tests.sim_nodes.client import Client, pose

# All notations of poses and masses.
TOY = """
<mujoco model="toy">
  <compiler angle="radian"/>
  <default><geom friction="0.7" density="500"/></default>
  <worldbody>
    <body name="toy">
      <freejoint/>
      <geom type="box" rgba="0.1 0.2 0.3 1" size="0.1 0.2 0.05" pos="0 0 0.05" euler="0.1 0.2 0.3"/>
      <geom type="cylinder" size="0.03 0.1" pos="0.05 0.1 0.25" axisangle="1 2 0 0.5" mass="0.3"/>
      <body name="arm" pos="0 0 0.3" quat="0.8 0 0.6 0">
        <geom type="sphere" size="0.08" pos="0.1 0 0"/>
        <body pos="0.1 0.1 0.1" zaxis="1 1 1">
          <geom type="cylinder" fromto="0 0 0 0.1 0.2 0.3" size="0.02"/>
          <inertial pos="0.05 0.1 0.15" mass="0.7" diaginertia="1 1 1"/>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>
"""
GEOM = '<geom type="box" size="0.1 0.1 0.1"/>'
FREE = "<freejoint/>"
WEDGE = to_stl(Mesh(np.vstack([np.zeros(3), np.eye(3)]), [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]))


def mjcf(*world: str, head: str = "") -> str:
    return f"<mujoco>{head}<worldbody>{''.join(world)}</worldbody></mujoco>"


def body(*content: str, attributes: str = "") -> str:
    return f"<body {attributes}>{''.join(content)}</body>"


def test_shapes_masses_and_friction_are_read() -> None:
    model = parse_model(TOY)
    box, rod, ball, end = model.parts
    assert (box.shape, rod.shape, ball.shape) == (Box((0.2, 0.4, 0.1)), Cylinder(0.03, 0.2), Sphere(0.08))
    assert isinstance(end.shape, Cylinder)
    assert end.shape.length == pytest.approx(np.sqrt(0.14))
    assert model.urdf is not None
    assert set(model.urdf.friction.values()) == {0.7}
    assert not model.static
    assert model.colour == pytest.approx((0.1, 0.2, 0.3, 1.0))


def test_poses_match_those_of_mujoco() -> None:
    mujoco = pytest.importorskip("mujoco")
    world = mujoco.MjModel.from_xml_string(TOY)
    data = mujoco.MjData(world)
    mujoco.mj_forward(world, data)
    model = parse_model(TOY)
    for number, part in enumerate(model.parts):
        assert part.position == pytest.approx(tuple(data.geom_xpos[number]))
        turn, theirs = rotation_matrix(part.orientation), data.geom_xmat[number].reshape(3, 3)
        if isinstance(part.shape, Box):
            assert turn == pytest.approx(theirs)
        # A cylinder may stand on either end.
        assert abs(float(turn[:, 2] @ theirs[:, 2])) == pytest.approx(1.0)
    assert model.mass == pytest.approx(float(world.body_subtreemass[1]))


def test_degrees_are_the_default() -> None:
    turned = GEOM.replace("/>", ' euler="0 0 90"/>')
    quarter = GEOM.replace("/>", ' quat="1 0 0 1"/>')
    parts = parse_model(mjcf(body(FREE, turned, quarter))).parts
    assert parts[0].orientation == pytest.approx(parts[1].orientation)


def test_bodies_without_a_joint_are_static() -> None:
    model = parse_model(mjcf(GEOM, body(GEOM, attributes='pos="1 0 0"')))
    assert model.static
    assert [part.position for part in model.parts] == [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)]
    assert not parse_model(mjcf(body('<joint type="free"/>', GEOM))).static


def test_a_pose_in_the_file_does_not_move_a_spawned_body() -> None:
    assert parse_model(mjcf(body(FREE, GEOM, attributes='pos="5 0 1"'))).parts[0].position == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_spawned_body_falls_and_comes_to_rest(engine: str) -> None:
    client = Client("empty", engine=engine)
    client.spawn("toy", pose(2.0, 1.0, z=0.1), TOY)
    client.advance(4.0)
    state = client.simulator.simulation.engine.body_state("toy")
    assert np.abs((*state.linear, *state.angular)).max() < 0.02
    assert state.position[2] > -0.02


def test_joints_become_links_at_their_anchors() -> None:
    hinge = (
        '<joint name="h" axis="0 1 0" pos="0 0 -0.2" range="-30 60"/><joint name="s" type="slide" axis="1 0 0"/>'
    )
    model = parse_model(mjcf(body(FREE, GEOM, body(hinge, GEOM, attributes='pos="0 0 0.5"'))))
    assert model.urdf is not None
    assert model.urdf.joints == ("h", "s")
    robot: Any = ElementTree.fromstring(model.urdf.text)
    turned, moved = robot.findall("joint")
    assert (turned.get("type"), moved.get("type")) == ("revolute", "prismatic")
    assert [float(value) for value in turned.find("origin").get("xyz").split()] == pytest.approx([0.0, 0.0, 0.3])
    assert float(turned.find("limit").get("upper")) == pytest.approx(np.pi / 3)
    assert model.parts[1].position == pytest.approx((0.0, 0.0, 0.5))


def test_included_files_defaults_and_meshes_are_read() -> None:
    files = {
        "parts/shared.xml": mjcf(
            head='<default><default class="big"><geom size="0.4"/></default></default>'
        ).encode(),
        "meshes/wedge.stl": WEDGE,
    }
    head = '<include file="parts/shared.xml"/><compiler meshdir="meshes"/><asset><mesh file="wedge.stl"/></asset>'
    model = parse_model(mjcf('<geom class="big"/><geom type="mesh" mesh="wedge"/>', head=head), files)
    ball, wedge = model.parts
    assert ball.shape == Sphere(0.4)
    assert isinstance(wedge.shape, Hull)
    assert len(wedge.shape.points) == 4


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (mjcf(GEOM, head='<compiler angle="grad"/>'), "MuJoCo refuses the model: .*'grad'"),
        (mjcf('<geom class="a" size="0.1"/>'), "MuJoCo refuses the model"),
        (mjcf('<geom size="0.1" quat="0 0 0 0"/>'), "MuJoCo refuses the model"),
        ("<mujoco/>", "no shapes besides floors"),
        (mjcf('<geom type="plane" size="1 1 1"/>'), "no shapes besides floors"),
        (mjcf(body(FREE, GEOM), GEOM), "found 2 bodies in the file that move apart: body, scene; expected one"),
        (mjcf(GEOM, head='<include file="none.xml"/>'), "missing file 'none.xml' of <include>"),
        (mjcf(GEOM, head='<asset><mesh file="none.stl"/></asset>'), "missing file 'none.stl' of <mesh>"),
    ],
)
def test_invalid_models_are_refused_with_the_place(text: str, words: str) -> None:
    with pytest.raises(RequestRefused, match=words) as refused:
        parse_model(text)
    assert refused.value.code == SpawnResult.RESOURCE_PARSE_ERROR


@pytest.mark.parametrize("engine", ENGINES)
def test_things_fall_into_height_fields(engine: str) -> None:
    edge, middle = " 1 1 1 1 1 ", " 1 0 0 0 1 "
    field = f'<hfield name="bowl" nrow="5" ncol="5" size="1 1 0.4 0.1" elevation="{edge}{3 * middle}{edge}"/>'
    text = mjcf('<geom type="hfield" hfield="bowl" pos="0 0 0.1"/>', head=f"<asset>{field}</asset>")
    client = Client("empty", engine=engine)
    client.spawn("bowl", pose(3.0, 0.0), text)
    client.spawn("ball", pose(3.0, 0.0, z=1.0), mjcf(body(FREE, '<geom size="0.1"/>')))
    client.advance(2.0)
    assert client.simulator.simulation.engine.body_state("ball").position[2] == pytest.approx(0.2, abs=0.03)
