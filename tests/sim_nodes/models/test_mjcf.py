from __future__ import annotations

import numpy as np
import pytest

from seoro.bridges.wire import SpawnResult
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.__main__ import ENGINES
from sim_nodes.extents import inertia
from sim_nodes.geometry import rotation_matrix
from sim_nodes.models import parse_model
from sim_nodes.physics import Box, Cylinder, Sphere
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
    assert [box.mass, rod.mass, end.mass] == pytest.approx([4.0, 0.3, 0.7])
    assert (model.friction, model.static, model.colour) == (0.7, False, (0.1, 0.2, 0.3, 1.0))


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
    assert inertia(model).centre == pytest.approx(tuple(data.subtree_com[1]))


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


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (mjcf(GEOM, head="<actuator/>"), "<actuator>"),
        (mjcf(GEOM, head="<asset/>"), "<asset>"),
        (mjcf(GEOM, head='<compiler coordinate="global"/>'), "'coordinate'"),
        (mjcf(GEOM, head='<compiler angle="grad"/>'), "'grad'"),
        (mjcf(GEOM, head='<default><default class="a"/></default>'), "<default>"),
        ("<mujoco/>", "0 <worldbody>"),
        (mjcf("<light/>"), "<light>"),
        (mjcf(), "found 0 collision shapes"),
        (mjcf(body(FREE, GEOM), GEOM), "moves beside others"),
        (mjcf(body("<joint/>", GEOM)), "hinge joint"),
        (mjcf(body(FREE, GEOM, body(FREE, GEOM))), "free joint of the outermost"),
        (mjcf(body(FREE, FREE, GEOM)), "2 joints"),
        (mjcf(body(GEOM, "<site/>")), "<site>"),
        (mjcf(body(GEOM, attributes='mocap="true"')), "'mocap'"),
        (mjcf('<geom type="capsule" size="0.1 0.1"/>'), "'capsule'"),
        (mjcf('<geom type="plane" size="1 1 1"/>'), "'plane'"),
        (mjcf('<geom class="a" size="0.1"/>'), "'class'"),
        (mjcf('<geom size="0.1" condim="6"/>'), "'condim'"),
        (mjcf('<geom size="0.1" friction="1 0.1"/>'), "only the first value"),
        (mjcf('<geom size="0.1" friction="1"/>', '<geom size="0.1" friction="2"/>'), "different friction"),
        (mjcf('<geom type="box" size="0.1"/>'), "3 numbers"),
        (mjcf('<geom type="box" fromto="0 0 0 1 0 0" size="0.1"/>'), "for cylinders"),
        (mjcf('<geom type="cylinder" fromto="0 0 0 0 0 0" size="0.1"/>'), "0 m long"),
        (mjcf('<geom size="0.1" quat="0 0 0 0"/>'), "zero (length|axis)"),
        (mjcf('<geom size="0.1" quat="1 0 0 0" euler="0 0 0"/>'), "both 'euler' and 'quat'"),
        (mjcf(body(FREE, '<geom size="0.1" mass="0"/>')), "a mass of 0 kg"),
        (mjcf(body(FREE, '<inertial pos="1 0 0" mass="1"/>', GEOM)), "centre of mass"),
        (mjcf(body(FREE, '<inertial pos="0 0 0" mass="1"/>')), "no geom"),
        (mjcf("<body>" * 60 + "</body>" * 60), "deep"),
    ],
)
def test_unsupported_elements_are_refused_by_name(text: str, words: str) -> None:
    with pytest.raises(RequestRefused, match=words) as refused:
        parse_model(text)
    assert refused.value.code == SpawnResult.RESOURCE_PARSE_ERROR


def test_meshes_are_refused() -> None:
    with pytest.raises(RequestRefused, match="mesh") as refused:
        parse_model(mjcf('<geom type="mesh" size="1"/>'))
    assert refused.value.code == SpawnResult.UNSUPPORTED_ASSETS
