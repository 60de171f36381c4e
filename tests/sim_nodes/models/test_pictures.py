"""Pictures on meshes, from files to images of both engines."""

from __future__ import annotations

import io
import struct
import zlib
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

from seoro.bridges.model_files import gather
from sim_nodes.__main__ import ENGINES
from sim_nodes.check.bench import at, scene
from sim_nodes.inertia import volume
from sim_nodes.models import parse_model
from sim_nodes.models.primitives import surface_of
from sim_nodes.models.settings import ModelSettings
from sim_nodes.physics import BodyModel, Box, Capsule, Cylinder, Engine, Sphere
from sim_nodes.views import Lens, View, looking_at
from tests.sim_nodes.client import Client
from tests.sim_nodes.engines import make_engine, needs_pictures
from tests.sim_nodes.robots_of_makers import two_wheels, write_robot

# A square of 1 m that stands on the x axis and faces -y, with corners at those of the picture.
QUAD = """mtllib quad.mtl
v -0.5 0 0
v 0.5 0 0
v 0.5 0 1
v -0.5 0 1
vt 0 0
vt 1 0
vt 1 1
vt 0 1
usemtl painted
f 1/1 2/2 3/3
f 1/1 3/3 4/4
"""
MTL = "newmtl painted\nKd 0.2 0.2 0.2\nmap_Kd -s 1 1 1 flag.png\n"
PLAIN_MTL = "newmtl painted\nKd 1 1 1\n"
VISUAL = '<geometry><mesh filename="quad.obj"/></geometry>'
URDF = f'<robot name="r"><link name="l"><visual>{VISUAL}{{}}</visual></link></robot>'
BY_URDF = URDF.format('<material name="m"><texture filename="package://p/flag.png"/></material>')
SDF = """<sdf version="1.9"><model name="m"><static>true</static><link name="l"><visual name="v">
<geometry><mesh><uri>quad.obj</uri></mesh></geometry>
<material><diffuse>1 1 1 1</diffuse><pbr><metal><albedo_map>flag.png</albedo_map></metal></pbr></material>
</visual></link></model></sdf>"""
MJCF = """<mujoco><asset><mesh name="q" file="quad.obj" inertia="shell"/>
<texture name="t" type="2d" file="flag.png"/>
<material name="m" texture="t"/></asset><worldbody>
<geom type="mesh" mesh="q" material="m" contype="0" conaffinity="0"/></worldbody></mujoco>"""
COLOURS = {"red": (255, 0, 0), "green": (0, 255, 0), "blue": (0, 0, 255), "yellow": (255, 255, 0)}
FLAG = ("red", "green", "blue", "yellow")  # upper left and right, lower left and right
LENS = Lens(width=64, height=64)


def flag(size: int = 16) -> bytes:
    """Return a picture of four squares in PNG."""
    corners = np.array([COLOURS[name] for name in FLAG], dtype=np.uint8).reshape(2, 2, 3)
    found = io.BytesIO()
    Image.fromarray(corners.repeat(size // 2, axis=0).repeat(size // 2, axis=1)).save(found, "PNG")
    return found.getvalue()


FILES = {"quad.obj": QUAD.encode(), "quad.mtl": MTL.encode(), "flag.png": flag()}


def painted(text: str, picture: bytes = flag(), mtl: str = PLAIN_MTL) -> BodyModel:
    """Return a model whose mesh is the square."""
    files = {"quad.obj": QUAD.encode(), "quad.mtl": mtl.encode()}
    return parse_model(text, {**files, "flag.png": picture, "package/p/flag.png": picture})


def seen(engine: Engine, x: float = 0.0, y: float = 0.0, height: float = 0.5) -> tuple[str, ...]:
    """Return the names of the colours of a square in its corners, as a camera before its centre sees them."""
    place, target = (x, y - 1.6, height), (x, y, height)
    image = engine.render(View(place, looking_at(place, target), LENS)).astype(float)
    names = tuple(COLOURS)
    shades = np.array([COLOURS[name] for name in names], dtype=float)
    shades /= np.linalg.norm(shades, axis=1)[:, None]
    found = [image[row, column] for row in (22, 42) for column in (22, 42)]
    return tuple(names[int((shades @ pixel).argmax())] for pixel in found)


@pytest.mark.parametrize("engine", ENGINES)
def test_pictures_of_all_formats_are_seen_upright(engine: str) -> None:
    needs_pictures(engine)
    made = make_engine(engine)
    made.build(scene())
    models = (painted(URDF.format(""), mtl=MTL), painted(BY_URDF), painted(SDF), painted(MJCF))
    for index, model in enumerate(models):
        made.add_body(f"body{index}", model, at(2.0 * index, 0.0, 0.0))
    for index in range(len(models)):
        assert seen(made, 2.0 * index) == FLAG, index
    for _ in range(2):  # its name and those of its files are free again
        made.remove_body("body0")
        made.add_body("body0", models[0], at(0.0, 0.0, 0.0))
    assert seen(made) == FLAG


SHAPES = {
    '<box size="1 1 1"/>': FLAG,
    '<cylinder radius="0.5" length="1"/>': ("red", "red", "blue", "blue"),  # a quarter of the picture faces a side
    '<sphere radius="0.5"/>': ("red", "red", "blue", "blue"),
}


@pytest.mark.parametrize("engine", ENGINES)
def test_boxes_cylinders_and_spheres_show_pictures(engine: str) -> None:
    needs_pictures(engine)
    made = make_engine(engine)
    made.build(scene())
    of_sdf = SDF.replace("<mesh><uri>quad.obj</uri></mesh>", "<box><size>1 1 1</size></box>")
    of_mjcf = MJCF.replace('type="mesh" mesh="q"', 'type="box" size="0.5 0.5 0.5"')
    models = [painted(BY_URDF.replace('<mesh filename="quad.obj"/>', shape)) for shape in SHAPES]
    models.append(painted(of_sdf))
    if engine == "pybullet":  # MuJoCo lays the picture of MJCF over a box from above
        models.append(painted(of_mjcf))
    for index, model in enumerate(models):
        made.add_body(f"body{index}", model, at(3.0 * index, 0.0, 0.5))
    expected = [*SHAPES.values(), FLAG, FLAG]
    for index in range(len(models)):
        assert seen(made, 3.0 * index) == expected[index], index


def test_planes_show_pictures() -> None:
    model = painted(SDF.replace("<mesh><uri>quad.obj</uri></mesh>", "<plane><size>9 9</size></plane>"))
    assert model.urdf is not None and set(model.urdf.meshes) == {"mesh1.obj", "picture0.png"}


def test_surfaces_face_outwards() -> None:
    for shape in (Box((1.0, 2.0, 3.0)), Cylinder(0.5, 2.0), Sphere(0.5)):
        surface = surface_of(shape)
        assert surface is not None and surface.coordinates is not None
        a, b, c = surface.vertices[surface.faces.T]
        outwards = np.einsum("ij,ij->i", np.cross(b - a, c - a), a + b + c)
        assert outwards.min() > 0.0
        assert outwards.sum() / 18.0 == pytest.approx(volume(shape), rel=0.02)
        assert surface.coordinates.min() >= 0.0 and surface.coordinates.max() <= 1.0
    assert surface_of(Capsule(0.1, 1.0)) is None


class Bullet:
    """Counts the pictures that are loaded."""

    loaded = 0

    def loadTexture(self, path: str) -> int:
        self.loaded += 1
        return self.loaded

    def changeVisualShape(self, body: int, link: int, shape: int, textureUniqueId: int) -> None:  # noqa: N803
        assert (link, shape, textureUniqueId) == (-1, 0, 1)


def test_pybullet_loads_a_picture_once_per_world() -> None:
    make_engine("pybullet")
    from sim_nodes.pybullet.textures import Textures

    model, bullet = painted(BY_URDF), Bullet()
    assert model.urdf is not None
    textures, root = Textures(bullet), ElementTree.fromstring(model.urdf.text)
    for body in range(3):  # Bullet frees no picture with its body
        textures.show(body, root, model.urdf.meshes, {-1: "l"})
    assert bullet.loaded == 1


@pytest.mark.parametrize("engine", ENGINES)
def test_robots_have_pictures(engine: str, tmp_path: Path) -> None:
    needs_pictures(engine)
    for name, data in FILES.items():
        (tmp_path / name).write_bytes(data)
    visual = f'<visual><origin xyz="0 -0.4 0"/>{VISUAL}</visual>'
    urdf = two_wheels().replace('<link name="top"/>', f'<link name="top">{visual}</link>')
    client = Client(write_robot(tmp_path, urdf, "differential"), engine=engine)
    assert seen(client.simulator.simulation.engine, x=1.1, y=-0.4, height=0.75) == FLAG


def test_a_colour_of_the_model_replaces_its_pictures() -> None:
    model = parse_model(URDF.format(""), FILES, ModelSettings(colour=(0.0, 0.0, 1.0, 1.0)))
    assert model.urdf is not None
    assert list(model.urdf.meshes) == ["mesh0.stl"]


def test_the_main_colour_is_the_mean_of_the_picture() -> None:
    assert painted(BY_URDF).colour == pytest.approx((0.5, 0.5, 0.25, 1.0))


def test_large_pictures_are_scaled_down() -> None:
    model = painted(BY_URDF, flag(1600))
    assert model.urdf is not None
    with Image.open(io.BytesIO(model.urdf.meshes["picture0.png"])) as picture:
        assert picture.size == (1024, 1024)


def header(edge: int) -> bytes:
    """Return the beginning of a square picture in PNG; `edge` is in pixels."""
    size = struct.pack(">IIBBBBB", edge, edge, 8, 2, 0, 0, 0)
    chunks = ((b"IHDR", size), (b"IDAT", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in chunks
    )


@pytest.mark.parametrize(
    ("picture", "reason"),
    [
        (header(20_000), "has more than 16,777,216 pixels"),
        (header(11_000), "has more than 16,777,216 pixels"),
        (header(5_000), "has more than 16,777,216 pixels"),
        (flag()[:60], "is damaged, or not in one of the formats PNG, JPEG, BMP, TGA, GIF, TIFF"),
        (b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 9 9\n", "is damaged, or not in one of the formats PNG"),
    ],
)
@pytest.mark.parametrize("mtl", [MTL, None])
def test_an_unusable_picture_is_noted(picture: bytes, reason: str, mtl: str | None) -> None:
    model = painted(BY_URDF, picture) if mtl is None else painted(URDF.format(""), picture, mtl)
    path = "package/p/flag.png" if mtl is None else "flag.png"
    assert any(note.startswith(f"without effect: the picture '{path}' {reason}") for note in model.notes)
    assert model.urdf is not None
    assert list(model.urdf.meshes) == ["mesh0.stl"]


def test_a_missing_picture_is_noted() -> None:
    files = {"quad.obj": QUAD.encode(), "quad.mtl": MTL.encode()}
    assert "without effect: the picture 'flag.png' is missing" in parse_model(URDF.format(""), files).notes


def test_pictures_without_places_are_noted() -> None:
    bare = "\n".join(line for line in QUAD.splitlines() if not line.startswith("vt")).replace("/1", "")
    bare = bare.replace("/2", "").replace("/3", "").replace("/4", "")
    files = {"quad.obj": bare.encode(), "package/p/flag.png": flag()}
    notes = parse_model(BY_URDF, files).notes
    assert "without effect: <texture> of <visual>, whose mesh has no texture coordinates" in notes
    capsule = BY_URDF.replace('<mesh filename="quad.obj"/>', '<capsule radius="0.2" length="1"/>')
    assert (
        "without effect: <texture> of a <capsule>; expected a mesh, box, cylinder, sphere or plane"
        in parse_model(capsule, files).notes
    )


def test_pictures_of_sdf_are_gathered(tmp_path: Path) -> None:
    for name, data in {**FILES, "model.sdf": SDF.encode()}.items():
        (tmp_path / name).write_bytes(data)
    assert set(gather(tmp_path / "model.sdf").files) == set(FILES)


def test_shapes_of_mjcf_have_the_mean_colour_of_their_texture() -> None:
    text = MJCF.replace('type="mesh" mesh="q"', 'type="ellipsoid" size="0.5 0.01 0.5"')
    assert painted(text).colour == pytest.approx((0.5, 0.5, 0.25, 1.0))
