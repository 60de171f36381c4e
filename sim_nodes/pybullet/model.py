"""Scenes, robots and bodies as URDF that Bullet loads, and what URDF cannot say: friction, motors, damping.

All shapes go through URDF: other ways to make bodies take 16 shapes at most, and approximate their inertia.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any, assert_never
from xml.etree import ElementTree

from sim_nodes.colours import Colour
from sim_nodes.geometry import Quaternion, Vector, roll_pitch_yaw
from sim_nodes.inertia import inertia
from sim_nodes.physics import (
    IDENTITY,
    BodyModel,
    BodyState,
    Box,
    Cylinder,
    PlacedRobot,
    Shape,
    Sphere,
    Wall,
)
from sim_nodes.pybullet.output import caught
from sim_nodes.robots.declaration import DriveDeclaration

FASTEST = 1e5  # [m/s], [rad/s]; Bullet's own limit of a body's velocity is 100, also for those without joints
BASE = -1  # Bullet's index of the link that is no joint's child
XYZW = tuple[float, float, float, float]  # Bullet's order of quaternions


class Links:
    """Indices of the links and joints of a loaded robot, by name; a joint has the index of its child."""

    def __init__(self, bullet: Any, body: int) -> None:
        infos = [bullet.getJointInfo(body, index) for index in range(bullet.getNumJoints(body))]
        self.joints: dict[str, int] = {info[1].decode(): info[0] for info in infos}
        self.links: dict[str, int] = {info[12].decode(): info[0] for info in infos}
        self.links[bullet.getBodyInfo(body)[0].decode()] = BASE


def xyzw(orientation: Quaternion) -> XYZW:
    """A quaternion in Bullet's order."""
    w, x, y, z = orientation
    return x, y, z, w


def wxyz(orientation: XYZW) -> Quaternion:
    """A quaternion of Bullet in ours."""
    x, y, z, w = orientation
    return w, x, y, z


def load_robot(bullet: Any, robot: PlacedRobot) -> tuple[int, Links]:
    """Load a robot; returns the number of its body and the indices of its links."""
    declaration = robot.declaration
    body = _load(bullet, declaration.urdf, robot.state, static=declaration.fixed)
    links = Links(bullet, body)
    for index in links.links.values():
        bullet.changeDynamics(body, index, lateralFriction=declaration.body_friction)
    for name in declaration.low_friction_links:
        bullet.changeDynamics(body, links.links[name], lateralFriction=0.0)
    if declaration.mobile is not None:
        drive = declaration.mobile.drive
        for wheel in wheels(links, drive):
            bullet.changeDynamics(body, wheel, lateralFriction=drive.wheel_friction)
    _undamp(bullet, body)
    return body, links


def wheels(links: Links, drive: DriveDeclaration) -> tuple[int, int]:
    """Indices of the left and the right wheel."""
    return links.joints[drive.left_joint], links.joints[drive.right_joint]


def load_body(bullet: Any, model: BodyModel, state: BodyState, colour: Colour) -> int:
    """Load a body; returns its number."""
    body = _load(bullet, _urdf(model, colour), state, static=model.static)
    bullet.changeDynamics(body, BASE, lateralFriction=model.friction, maxJointVelocity=FASTEST)
    _undamp(bullet, body)
    return body


def _undamp(bullet: Any, body: int) -> None:
    """Let a body move on; with friction in the same call, Bullet gives that to the base, and not to the link."""
    bullet.changeDynamics(body, BASE, linearDamping=0.0, angularDamping=0.0)


def walls_body(walls: Iterable[Wall]) -> BodyModel:
    """Walls as one body at the origin."""
    return BodyModel(tuple(wall.part for wall in walls), static=True)


def _load(bullet: Any, urdf: str, state: BodyState, *, static: bool = False) -> int:
    # With convex hulls in place of cylinders, wheels are polygons and robots 3 % too fast.
    flags = bullet.URDF_USE_INERTIA_FROM_FILE | bullet.URDF_USE_IMPLICIT_CYLINDER
    with tempfile.TemporaryDirectory(prefix="seoro-") as folder, caught():
        path = Path(folder) / "model.urdf"
        # Bullet breaks lines after 8 KiB, also in the middle of a word.
        path.write_text(urdf.replace("><", ">\n<"), encoding="utf-8")
        body: int = bullet.loadURDF(
            str(path), state.position, xyzw(state.orientation), useFixedBase=static, flags=flags
        )
    return body


def _urdf(model: BodyModel, colour: Colour) -> str:
    root = ElementTree.Element("robot", name="body")
    link = ElementTree.SubElement(root, "link", name="body")
    spread = inertia(model)
    inertial = ElementTree.SubElement(link, "inertial")
    _origin(inertial, spread.centre, spread.axes)
    ElementTree.SubElement(inertial, "mass", value=repr(model.mass))
    ixx, iyy, izz = map(repr, spread.moments)
    ElementTree.SubElement(inertial, "inertia", ixx=ixx, iyy=iyy, izz=izz, ixy="0", ixz="0", iyz="0")
    for part in model.parts:
        for purpose in ("collision", "visual"):
            element = ElementTree.SubElement(link, purpose)
            _origin(element, part.position, part.orientation)
            _geometry(ElementTree.SubElement(element, "geometry"), part.shape)
    for visual in link.iter("visual"):
        material = ElementTree.SubElement(visual, "material", name="colour")
        ElementTree.SubElement(material, "color", rgba=_numbers(colour))
    return ElementTree.tostring(root, encoding="unicode")


def _origin(parent: ElementTree.Element, position: Vector, orientation: Quaternion) -> None:
    rpy = (0.0, 0.0, 0.0) if orientation == IDENTITY else roll_pitch_yaw(orientation)
    ElementTree.SubElement(parent, "origin", xyz=_numbers(position), rpy=_numbers(rpy))


def _geometry(parent: ElementTree.Element, shape: Shape) -> None:
    match shape:
        case Box(size=size):
            ElementTree.SubElement(parent, "box", size=_numbers(size))
        case Cylinder(radius=radius, length=length):
            ElementTree.SubElement(parent, "cylinder", radius=repr(radius), length=repr(length))
        case Sphere(radius=radius):
            ElementTree.SubElement(parent, "sphere", radius=repr(radius))
        case _:
            assert_never(shape)


def _numbers(values: Iterable[float]) -> str:
    return " ".join(map(repr, values))
