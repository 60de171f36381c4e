"""Concave meshes: their hulls by default, and convex pieces on request."""

from __future__ import annotations

from pathlib import Path

import pytest
import trimesh

from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.__main__ import ENGINES
from sim_nodes.check.bench import at, run, scene
from sim_nodes.models import parse_model
from sim_nodes.models.meshes import Mesh, to_stl
from sim_nodes.models.settings import ModelSettings
from sim_nodes.worlds.loader import WorldError, parse_world
from tests.sim_nodes.engines import make_engine

SHAPE = '<geometry><mesh filename="ring.stl"/></geometry>'
BODY = f"""<robot name="ring"><link name="l"><inertial><mass value="1"/></inertial>
<visual>{SHAPE}</visual><collision>{SHAPE}</collision></link></robot>"""
BALL = """<robot name="ball"><link name="l"><inertial><mass value="0.1"/></inertial>
<collision><geometry><sphere radius="0.05"/></geometry></collision></link></robot>"""
DECOMPOSED = ModelSettings(decompose=True)


@pytest.fixture(scope="module")
def files() -> dict[str, bytes]:
    """A square ring of 10 cm height with a hole."""
    ring = trimesh.creation.annulus(0.15, 0.2, 0.1, sections=4)
    return {"ring.stl": to_stl(Mesh(ring.vertices, ring.faces))}


@pytest.mark.parametrize(("settings", "height"), [(ModelSettings(), 0.15), (DECOMPOSED, 0.05)])
@pytest.mark.parametrize("engine", ENGINES)
def test_a_ball_falls_into_the_hole_of_a_decomposed_ring(
    engine: str, settings: ModelSettings, height: float, files: dict[str, bytes]
) -> None:
    pytest.importorskip("coacd")
    made = make_engine(engine)
    made.build(scene())
    made.add_body("ring", parse_model(BODY, files, settings), at(0.0, 0.0, 0.05))
    made.add_body("ball", parse_model(BALL), at(0.0, 0.0, 0.25))
    run(made, 1.5)
    assert made.body_state("ball").position[2] == pytest.approx(height, abs=0.02)


def test_a_convex_mesh_stays_one_piece() -> None:
    box = trimesh.creation.box((0.1, 0.1, 0.1))
    model = parse_model(BODY, {"ring.stl": to_stl(Mesh(box.vertices, box.faces))}, DECOMPOSED)
    assert len(model.parts) == 1


def test_large_meshes_are_refused() -> None:
    pytest.importorskip("coacd")
    ring = trimesh.creation.torus(0.2, 0.1, 150, 80)
    with pytest.raises(RequestRefused, match="to decompose has 24000 triangles; expected at most 20000"):
        parse_model(BODY, {"ring.stl": to_stl(Mesh(ring.vertices, ring.faces))}, DECOMPOSED)


def test_props_are_decomposed(tmp_path: Path, files: dict[str, bytes]) -> None:
    pytest.importorskip("coacd")
    (tmp_path / "ring.urdf").write_text(BODY)
    (tmp_path / "ring.stl").write_bytes(files["ring.stl"])
    (tmp_path / "box.xml").write_text("<mujoco><worldbody><geom size='0.1'/></worldbody></mujoco>")
    text = "name: w\nextent: [-4, -4, 4, 4]\nprops: [{{name: a, {}, decompose: true}}]\n"
    [prop] = parse_world(text.format("model: ring.urdf"), "w", tmp_path).props
    assert len(prop.model.parts) > 1
    with pytest.raises(WorldError, match="unexpected `decompose`: only models have meshes"):
        parse_world(text.format("cube: 0.2"), "w", tmp_path)
    with pytest.raises(WorldError, match="unexpected `decompose` for MJCF"):
        parse_world(text.format("model: box.xml"), "w", tmp_path)
