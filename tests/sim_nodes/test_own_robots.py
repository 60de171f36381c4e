"""Robots of users: a declaration and a URDF, named by a world file."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from seoro.bridges import wire
from sim_nodes.__main__ import ENGINES
from sim_nodes.models.meshes import Mesh, hull, to_stl
from sim_nodes.worlds.loader import WorldError, load_world
from tests.sim_nodes.client import Client

WORKSHOP = Path(__file__).parents[2] / "examples" / "workshop"
WORLD = "name: w\nextent: [-4, -4, 4, 4]\nrobots: [{name: mine, robot: robots/cart.yaml, pose: {x: 1.0}}]\n"
CAMERA = """cameras:
  - {name: eye, link: base_link, x: 0.1, y: 0, z: 0.2, fov: 0.9, width: 64, height: 48}
"""

Change = Callable[[str], str]


def world_with(folder: Path, *, urdf: Change = str, declaration: Change = str) -> str:
    """Write a world with the cart of the example, with changed files."""
    robots = folder / "robots"
    robots.mkdir()
    (robots / "cart.urdf").write_text(urdf((WORKSHOP / "cart.urdf").read_text()))
    (robots / "cart.yaml").write_text(declaration((WORKSHOP / "cart.yaml").read_text()))
    path = folder / "w.yaml"
    path.write_text(WORLD)
    return str(path)


def replaced(old: str, new: str) -> Change:
    def change(text: str) -> str:
        assert old in text
        return text.replace(old, new, 1)

    return change


def with_mesh(text: str) -> str:
    """Replace the box of the cart, also where it is solid, by a mesh with corners of the same box."""
    box = '<box size="0.4 0.24 0.14"/>'
    assert text.count(box) == 2
    return text.replace(box, '<mesh filename="package://robots/meshes/body.stl" scale="0.001 0.001 0.001"/>')


@pytest.mark.parametrize("urdf", [str, with_mesh])
@pytest.mark.parametrize("engine", ENGINES)
def test_a_user_declared_robot_drives_as_far_as_its_wheels_turn(engine: str, urdf: Change, tmp_path: Path) -> None:
    corners = np.array([[x, y, z] for x in (-200, 200) for y in (-120, 120) for z in (-70, 70)], dtype=float)
    path = world_with(tmp_path, urdf=urdf)
    (tmp_path / "robots" / "meshes").mkdir()
    (tmp_path / "robots" / "meshes" / "body.stl").write_bytes(to_stl(hull(Mesh(corners, np.zeros((0, 3), int)))))
    client = Client(path, engine=engine)
    [robot] = client.ask(wire.GET_SIMULATOR_FEATURES, wire.Empty()).robots
    assert (robot.name, robot.kinds[0]) == ("mine", "differential_drive_robot")
    client.ask(wire.DRIVE, wire.Drive(id="d", robot="mine", linear=0.3, angular=0.0, duration=3.0))
    client.run_until("d")
    pose = client.simulator.simulation.frames.true_pose("mine")
    # 0.9 m, less what speeding up to 0.3 m/s with 0.8 m/s^2 takes.
    assert (pose.x, pose.y, pose.yaw) == pytest.approx((1.84, 0.0, 0.0), abs=0.02)


@pytest.mark.parametrize(
    ("urdf", "words"),
    [
        (replaced("<robot", "<robot"), None),
        (replaced('<box size="0.4 0.24 0.14"/>', '<mesh filename="a.stl"/>'), "missing mesh 'a.stl'"),
        (replaced('<link name="lidar">', '<link name="eye">'), "unknown child link 'lidar'"),
        (replaced('type="continuous"', 'type="screw"'), "'screw'"),
        (replaced('type="continuous"', 'type="fixed"'), "'continuous'"),
        (replaced('xyz="0 0.15 0.06"', 'xyz="0 0.2 0.06"'), "`wheel_separation`"),
        (replaced('xyz="0 -0.15 0.06"', 'xyz="0.1 -0.15 0.06"'), "`wheel_separation`"),
        (replaced('xyz="0.1 0 0.22"', 'xyz="0.1 0 0.22" rpy="0 0 1"'), "turned by 1.0000 rad"),
        (replaced('<link name="lidar">', '<link name="left_wheel">'), "missing or duplicate name"),
        (replaced('<child link="lidar"/>', '<child link="left_wheel"/>'), "child of two joints"),
        (
            replaced('<child link="front_caster"/>', '<child link="base_link"/>'),
            "is its own ancestor",
        ),
        (replaced('<axis xyz="0 0 1"/>', '<axis xyz="0 0"/>'), "axis of <joint name='left_wheel_joint'>"),
        (replaced('<axis xyz="0 0 1"/>', '<axis xyz="0 0 0"/>'), "zero (length|axis)"),
        (replaced('<origin xyz="0 0 0.12"/>', '<origin xyz="0 0"/>'), "xyz of <inertial>"),
        (replaced('<axis xyz="0 0 1"/>', '<dynamics damping="much"/>'), "damping of <joint"),
        (
            replaced('<mass value="6"/>', '<mass value="six"/>'),
            r"\(line 4\): invalid mass of <link name='base_link'>",
        ),
        (replaced("<robot", "<sdf"), "invalid XML"),
    ],
)
def test_a_urdf_that_does_not_fit_is_refused(urdf: Change, words: str | None, tmp_path: Path) -> None:
    path = world_with(tmp_path, urdf=urdf)
    if words is None:
        assert load_world(path).robots[0].declaration.model == "cart"
        return
    with pytest.raises(WorldError, match=words) as error:
        load_world(path)
    assert f"{path}:3: robots.0.robot: the URDF of {tmp_path / 'robots' / 'cart.yaml'}" in str(error.value)


@pytest.mark.parametrize(
    ("urdf", "note"),
    [
        (replaced('<mass value="6"/>', ""), "link 'base_link' has no mass: 13.4 kg by its volume, at 1000 kg/m^3"),
        (replaced('ixx="0.053"', ""), "no body can have the inertia of link 'base_link'"),
        (replaced('ixx="0.053"', 'ixx="0.9"'), "no body can have the inertia of link 'base_link'"),
        (replaced('ixy="0" ', 'ixy="5" '), "no body can have the inertia of link 'base_link'"),
        (
            replaced('<mass value="6"/>', '<mass value="6"/><mass value="7"/>'),
            "without effect: a second <mass> of <link name='base_link'>",
        ),
        (replaced('<joint name="rear', '<gazebo/><joint name="rear'), "without effect: <gazebo>"),
    ],
)
def test_changes_of_a_urdf_are_warnings_of_the_world(urdf: Change, note: str, tmp_path: Path) -> None:
    [warning] = load_world(world_with(tmp_path, urdf=urdf)).warnings
    assert warning.startswith(f"robots.0: {note}")


@pytest.mark.parametrize(
    ("declaration", "words"),
    [
        (replaced("urdf: cart.urdf", "urdf: none.urdf"), "cannot read .*none.urdf"),
        (replaced("urdf: cart.urdf\n", ""), "missing `urdf`"),
        (replaced("model: cart", "model: [cart"), "invalid YAML"),
        (replaced("wheel_radius: 0.06", "wheel_radius: -1"), "mobile.drive.wheel_radius"),
        (replaced("wheel_radius: 0.06", "wheel_radius: 0.6"), "`wheel_radius` declares 0.6000 m"),
        (
            lambda text: re.sub("motor_torque: .*", "motor_torque: .inf", text),
            "mobile.drive.motor_torque: .*finite",
        ),
        (lambda text: re.sub("distance_noise: [^,}]*", "distance_noise: .nan", text), "distance_noise: .*finite"),
        (replaced("wheel_radius", "wheel_diameter"), "wheel_diameter: unknown key"),
        (
            replaced("left_joint: left_wheel_joint", "left_joint: wheel"),
            "unknown joint 'wheel' in the declaration",
        ),
        (replaced("rear_caster", "caster"), "unknown link 'caster' in the declaration"),
        (lambda text: text + CAMERA.replace("eye", "lidar"), "duplicate name 'lidar' of a camera"),
        (lambda text: text + CAMERA + CAMERA.partition("\n")[2], "duplicate name 'eye' of a camera"),
        (lambda text: text + CAMERA.replace("eye", "a/b"), "cameras.0.name"),
        (lambda text: text + CAMERA.replace("64", "99999"), "cameras.0.width"),
    ],
)
def test_an_invalid_declaration_is_refused(declaration: Change, words: str, tmp_path: Path) -> None:
    path = world_with(tmp_path, declaration=declaration)
    with pytest.raises(WorldError, match=words) as error:
        load_world(path)
    assert str(error.value).startswith(f"{path}:3: robots.0.robot: ")


def test_an_unknown_robot_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "w.yaml"
    path.write_text(WORLD)
    with pytest.raises(WorldError, match=r"cannot read .*robots/cart.yaml"):
        load_world(str(path))


@pytest.mark.parametrize("name", ["turtlebot4", "ur10e"])
def test_bundled_robots_pass_the_same_check(name: str, tmp_path: Path) -> None:
    from sim_nodes.robots.reading import load_robot
    from sim_nodes.robots.urdf_check import check_urdf

    declaration = load_robot(name)
    check_urdf(declaration)
    assert declaration.model == name
