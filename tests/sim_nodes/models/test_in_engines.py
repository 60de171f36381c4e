"""Bodies from files in both engines: meshes, joints, and the same body by its shapes."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest

from seoro.bridges import wire
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.__main__ import ENGINES
from sim_nodes.check.bench import at, run, scene
from sim_nodes.codec import pack, unpack
from sim_nodes.extents import bounding_box, lowest_point
from sim_nodes.models import parse_model
from sim_nodes.models.meshes import Mesh, hull, to_stl
from sim_nodes.physics import BodyState, Box, Engine, Hull, SavesState
from tests.sim_nodes.client import Client, pose
from tests.sim_nodes.engines import make_engine

CORNERS = np.array([[x, y, z] for x in (-0.1, 0.1) for y in (-0.2, 0.2) for z in (0.0, 0.3)])
CRATE = to_stl(hull(Mesh(CORNERS, np.zeros((0, 3), dtype=int))))
MESH = """<robot name="crate"><link name="crate">
<inertial><mass value="3"/></inertial>
<visual><geometry><mesh filename="package://crates/crate.stl"/></geometry></visual>
<collision><geometry><mesh filename="package://crates/crate.stl"/></geometry></collision>
</link></robot>"""
FILES = {"package/crates/crate.stl": CRATE}
# A bar of 1 m on a stand, which falls about its end to a side.
BARRIER = """<robot name="barrier"><link name="world"/>
<link name="stand"><inertial><mass value="9"/></inertial>
<collision><origin xyz="0 0 0.4"/><geometry><box size="0.1 0.1 0.8"/></geometry></collision></link>
<link name="bar"><inertial><mass value="1"/></inertial>
<collision><origin xyz="0.5 0 0" rpy="0 1.5708 0"/>
<geometry><capsule radius="0.03" length="0.9"/></geometry></collision></link>
<joint name="foot" type="fixed"><parent link="world"/><child link="stand"/></joint>
<joint name="hinge" type="revolute"><parent link="stand"/><child link="bar"/>
<origin xyz="0 0.15 0.8"/>
<axis xyz="0 1 0"/><limit lower="-1" upper="1.4"/>
<dynamics damping="0.1" friction="{friction}"/></joint></robot>"""
TUMBLER = """<mujoco><compiler angle="radian"/><worldbody><geom type="plane" size="5 5 1"/>
<body pos="0 0 3"><freejoint/><geom type="box" size="0.1 0.1 0.1"/>
<body pos="0 0 0.2"><joint type="hinge" axis="0 1 0" range="-1 1"/>
<geom type="capsule" size="0.03" fromto="0 0 0 0 0 0.4"/>
</body></body></worldbody></mujoco>"""

# Two level bars on hinges; the second one follows the first, and balances it if it turns the other way.
BAR = """<link name="{0}"><inertial><origin xyz="0.5 0 0"/><mass value="1"/></inertial>
<collision><origin xyz="0.5 0 0"/><geometry><box size="1 0.05 0.05"/></geometry></collision></link>"""
PAIR = f"""<robot name="pair"><link name="world"/>{BAR.format("a")}{BAR.format("b")}
<joint name="ja" type="continuous"><parent link="world"/><child link="a"/><axis xyz="0 1 0"/></joint>
<joint name="jb" type="continuous"><parent link="world"/><child link="b"/><origin xyz="0 1 0"/><axis xyz="0 1 0"/>
<mimic joint="ja" multiplier="{{multiplier}}"/></joint></robot>"""


def built(engine: str) -> Engine:
    made = make_engine(engine)
    made.build(scene())
    return made


def falls_on(engine: Engine, text: str) -> bool:
    """Whether the bar of a barrier falls on a box below it within two seconds."""
    engine.add_body("barrier", parse_model(text), at(0.0, 0.0, 0.0))
    engine.add_body("box", parse_model(MESH, FILES), at(0.6, 0.15, 0.0))
    for _ in range(40):
        run(engine, 0.05)
        if ("barrier", "box") in engine.touching():
            return True
    return False


def test_a_mesh_has_the_size_and_mass_of_its_file() -> None:
    model = parse_model(MESH, FILES)
    [part] = model.parts
    assert isinstance(part.shape, Hull)
    box = bounding_box(model.parts)
    assert box is not None
    assert box.lower == pytest.approx([-0.1, -0.2, 0.0], abs=1e-6)
    assert box.upper == pytest.approx([0.1, 0.2, 0.3], abs=1e-6)
    assert lowest_point(model, BodyState((0.0, 0.0, 1.0))) == pytest.approx(1.0, abs=1e-6)
    assert model.mass == 3.0


@pytest.mark.parametrize("engine", ENGINES)
def test_a_mesh_moves_like_the_box_that_it_shows(engine: str) -> None:
    box = '<box size="0.2 0.4 0.3"/>'
    shapes = MESH.replace('<mesh filename="package://crates/crate.stl"/>', box)
    shapes = shapes.replace("<visual>", '<visual><origin xyz="0 0 0.15"/>')
    shapes = shapes.replace("<collision>", '<collision><origin xyz="0 0 0.15"/>')
    found = []
    for text in (MESH, shapes):
        made = built(engine)
        made.add_body("crate", parse_model(text, FILES), BodyState((0.0, 0.0, 0.5), linear=(0.5, 0.0, 0.0)))
        run(made, 2.0)
        found.append(made.body_state("crate").position)
    assert found[0][2] == pytest.approx(0.0, abs=5e-3)
    assert found[0] == pytest.approx(found[1], abs=0.02)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_hinge_lets_its_link_fall(engine: str) -> None:
    assert falls_on(built(engine), BARRIER.format(friction=0.0))


@pytest.mark.parametrize("engine", ENGINES)
def test_friction_of_a_hinge_holds_its_link(engine: str) -> None:
    assert not falls_on(built(engine), BARRIER.format(friction=50.0))


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(("multiplier", "falls"), [(0.5, True), (-1.0, False)])
def test_a_joint_follows_another(engine: str, multiplier: float, falls: bool) -> None:
    made = built(engine)
    made.add_body("pair", parse_model(PAIR.format(multiplier=multiplier)), at(0.0, 0.0, 1.0))
    made.add_body("box", parse_model(MESH, FILES), at(0.6, 0.0, 0.0))
    touched = False
    for _ in range(20):
        run(made, 0.05)
        touched |= ("box", "pair") in made.touching()
    assert touched == falls
    made.remove_body("pair")
    made.add_body("pair", parse_model(PAIR.format(multiplier=multiplier)), at(0.0, 0.0, 1.0))
    run(made, 0.1)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_body_of_mjcf_comes_to_rest_on_the_floor(engine: str) -> None:
    made = built(engine)
    made.add_body("tumbler", parse_model(TUMBLER), at(0.0, 0.0, 0.3))
    run(made, 4.0)
    state = made.body_state("tumbler")
    assert 0.05 < state.position[2] < 0.2
    assert np.abs((*state.linear, *state.angular)).max() < 0.05


@pytest.mark.parametrize("engine", ENGINES)
def test_a_name_is_free_after_its_body_was_removed(engine: str) -> None:
    made = built(engine)
    for text, files in ((MESH, FILES), (TUMBLER, {}), (MESH, FILES)):
        made.add_body("thing", parse_model(text, files), at(0.0, 0.0, 0.4))
        run(made, 0.5)
        made.remove_body("thing")
    assert made.touching() == frozenset()


@pytest.mark.parametrize("engine", ENGINES)
def test_a_restored_engine_continues_bit_identically(engine: str) -> None:
    first = built(engine)
    first.add_body("gone", parse_model(MESH, FILES), at(1.0, 1.0, 0.1))
    first.remove_body("gone")
    first.add_body("barrier", parse_model(BARRIER.format(friction=0.01)), at(0.0, 0.0, 0.0))
    first.add_body("crate", parse_model(MESH, FILES), at(0.6, 0.15, 0.2))
    run(first, 0.3)
    assert isinstance(first, SavesState)
    saved = unpack(pack(first.save()))
    second = built(engine)
    assert isinstance(second, SavesState)
    second.restore(saved)
    for made in (first, second):
        run(made, 1.0)
    assert repr(first.body_state("crate")) == repr(second.body_state("crate"))


@pytest.mark.parametrize("engine", ENGINES)
def test_clients_send_meshes_with_a_model(engine: str) -> None:
    client = Client("empty", engine=engine)
    files = tuple(wire.NamedFile(path=path, data=data) for path, data in FILES.items())
    request = wire.SpawnEntity(
        name="crate", uri="crate.urdf", resource_string=MESH, files=files, initial_pose=pose(2.0, 1.0, z=0.05)
    )
    assert client.ask(wire.SPAWN_ENTITY, request).name == "crate"
    client.advance(1.0)
    assert client.simulator.simulation.engine.body_state("crate").position == pytest.approx((2, 1, 0), abs=5e-3)


def test_shapes_without_meshes_are_shapes_of_the_body() -> None:
    files: Mapping[str, bytes] = {}
    model = parse_model(BARRIER.format(friction=0.0), files)
    assert model.static
    assert isinstance(model.parts[0].shape, Box)
    assert model.urdf is not None
    assert model.urdf.joints == ("hinge",)


def test_pybullet_refuses_bodies_with_more_links_than_it_can_simulate() -> None:
    ball = (
        '<inertial><mass value="1"/></inertial><collision><geometry><sphere radius="0.1"/></geometry></collision>'
    )
    links = "".join(f'<link name="l{number}">{ball}</link>' for number in range(130))
    joints = "".join(
        f'<joint name="j{number}" type="continuous"><parent link="l0"/><child link="l{number}"/></joint>'
        for number in range(1, 130)
    )
    with pytest.raises(RequestRefused, match=r"the model has 130 links .* at most 128"):
        built("pybullet").add_body("many", parse_model(f"<robot>{links}{joints}</robot>"), at(0.0, 0.0, 1.0))
