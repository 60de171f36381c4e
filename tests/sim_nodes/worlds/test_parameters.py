"""Parameters of worlds, and maps, pictures and scenes as worlds."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from seoro.files.yaml_lines import FileError
from sim_nodes.worlds.files import files_of_world
from sim_nodes.worlds.loader import WorldError, load_world
from sim_nodes.worlds.parameters import set_parameters

MAP = "image: room.pgm\nresolution: 0.05\norigin: [-2.5, -2.5, 0]\nlaser_height: 0.1\n"
SDF = """
<sdf version="1.9"><world name="yard">
  <physics name="p" type="ode"/><light name="sun" type="directional"/><plugin name="x" filename="y"/>
  <model name="ground"><static>true</static><link name="l"><collision name="c">
    <geometry><plane><normal>0 0 1</normal></plane></geometry></collision></link></model>
  <model name="shed"><static>true</static><pose>3 0 0.5 0 0 0</pose><link name="l"><collision name="c">
    <geometry><box><size>1 2 1</size></box></geometry></collision></link></model>
  <model name="crate"><pose>0 2 0.2 0 0 0</pose><link name="l"><inertial><mass>2</mass></inertial>
    <collision name="c"><geometry><box><size>0.4 0.4 0.4</size></box></geometry></collision></link></model>
</world></sdf>
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    pixels = np.full((100, 100), 255, dtype=np.uint8)
    pixels[40:60, 40:60] = 0  # the origin is in a block of 1 m
    Image.fromarray(pixels).save(tmp_path / "room.pgm")
    Image.fromarray(pixels).save(tmp_path / "room.jpg")
    (tmp_path / "room.yaml").write_text(MAP)
    (tmp_path / "yard.sdf").write_text(SDF)
    return tmp_path


def test_parameters_set_keys_by_path() -> None:
    content = {"name": "w", "props": [{"name": "a", "mass": 1}, {"name": "b"}], "pose": "start"}
    after = set_parameters(content, "props.b.mass=2.5&props.0.static=true&pose.x=1&generate.seed=3&pose.y=-2")
    assert after == {
        "name": "w",
        "props": [{"name": "a", "mass": 1, "static": True}, {"name": "b", "mass": 2.5}],
        "pose": {"x": 1, "y": -2},
        "generate": {"seed": 3},
    }
    assert content["pose"] == "start"


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        ("seed", "invalid parameter `seed`; expected KEY=VALUE"),
        ("a=/etc/passwd", "invalid parameter `a=/etc/passwd`"),
        ("a=..", "invalid parameter"),
        ("a=[1]", "invalid parameter"),
        ("a.=1", "invalid parameter"),
        ("props.c.mass=1", r"unknown item `c`; expected a name \(a, b\), or a number below 2"),
        ("&".join(["a=1"] * 101), "found 101 parameters; expected at most 100"),
    ],
)
def test_invalid_parameters_are_refused(parameters: str, words: str) -> None:
    with pytest.raises(FileError, match=words):
        set_parameters({"props": [{"name": "a"}, {"name": "b"}]}, parameters)


def test_parameters_are_checked_like_the_file(folder: Path) -> None:
    assert load_world("hall?wall_height=1.5").walls[0].height == 1.5
    with pytest.raises(WorldError, match=r"hall.yaml:\d+: wall_heigth: unknown key .*did you mean `wall_height`"):
        load_world("hall?wall_heigth=1.5")


def test_a_map_is_a_world_with_a_robot_on_free_floor(folder: Path) -> None:
    world = load_world(str(folder / "room.yaml"))
    assert (world.name, world.extent) == ("room", (-2.5, -2.5, 2.5, 2.5))
    [robot] = world.robots
    assert robot.declaration.model == "turtlebot4"
    assert max(abs(robot.pose.x), abs(robot.pose.y)) == pytest.approx(0.8, abs=0.06)
    assert "ignored unknown key `laser_height`" in world.warnings[0]
    placed = load_world(f"{folder / 'room.yaml'}?robots.0.pose.x=2&robots.0.pose.at=null")
    assert (placed.robots[0].pose.x, placed.robots[0].pose.y) == (2.0, 0.0)


@pytest.mark.parametrize("name", ["room.jpg", "room.pgm"])
def test_a_picture_with_a_resolution_is_a_world(folder: Path, name: str) -> None:
    path = folder / name
    with pytest.raises(WorldError, match=rf"missing resolution .*`{name}\?floor_plan.resolution=0.05`"):
        load_world(str(path))
    world = load_world(f"{path}?floor_plan.resolution=0.05")
    assert world.extent == (0.0, 0.0, 5.0, 5.0)
    assert len(world.walls) >= 1
    assert list(files_of_world(f"{path}?floor_plan.resolution=0.05")) == [path]


def test_raw_pixels_of_100_are_walls_and_scale_has_the_walls_of_trinary(folder: Path) -> None:
    pixels = np.full((100, 100), 255, dtype=np.uint8)
    pixels[:, 50], pixels[:, 10], pixels[:, 20] = 100, 0, 120
    Image.fromarray(pixels).save(folder / "room.pgm")
    walls = {}
    for mode in ("raw", "scale", "trinary"):
        (folder / "room.yaml").write_text(f"{MAP}mode: {mode}\n")
        walls[mode] = [round(wall.x, 3) for wall in load_world(str(folder / "room.yaml")).walls]
    assert walls["raw"] == [0.025]
    assert walls["scale"] == walls["trinary"] == [-1.975]


def test_bodies_of_a_scene_are_props(folder: Path) -> None:
    path = folder / "yard.sdf"
    world = load_world(str(path))
    assert {prop.name: prop.model.static for prop in world.props} == {"shed": True, "crate": False}
    assert world.extent == (-2.0, -2.0, 5.0, 4.0)
    assert len(world.outlines) == 1
    assert list(files_of_world(str(path))) == [path]


def test_a_world_file_adds_robots_to_a_scene(folder: Path) -> None:
    text = "name: w\nscene: yard.sdf\nextent: [-5, -5, 5, 5]\n"
    robot = "robots: [{name: NAME, robot: turtlebot4, pose: {at: start}}]\n"
    path = folder / "w.yaml"
    path.write_text(text + robot.replace("NAME", "crate"))
    with pytest.raises(WorldError, match=r"w.yaml:4: robots.0.name: 'crate' is in use"):
        load_world(str(path))
    path.write_text(text + robot.replace("NAME", "tb"))
    assert load_world(str(path)).extent == (-5.0, -5.0, 5.0, 5.0)
    assert [file.name for file in files_of_world(str(path))] == ["w.yaml", "yard.sdf"]
    path.write_text("name: w\nscene: none.sdf\n")
    with pytest.raises(WorldError, match=r"w.yaml:2: scene: .*none.sdf"):
        load_world(str(path))
