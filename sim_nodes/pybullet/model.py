"""URDF of scenes, robots and bodies for Bullet, and settings that URDF lacks: friction, motors, damping.

All shapes are loaded by URDF: other functions accept at most 16 shapes, and approximate their inertia.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from copy import deepcopy
from pathlib import Path
from types import MappingProxyType
from typing import Any
from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np
from defusedxml.ElementTree import fromstring

from seoro.bridges.wire import SpawnResult
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.geometry import (
    Quaternion,
    Vector,
    conjugate,
    multiply,
    roll_pitch_yaw,
    rotated,
    rotation_matrix,
    vector,
)
from sim_nodes.inertia import inertia
from sim_nodes.models.urdf import paint, write_origin, write_shape
from sim_nodes.physics import (
    BodyModel,
    BodyState,
    PlacedRobot,
)
from sim_nodes.pybullet import captured_output
from sim_nodes.pybullet.mimic import couple_mimics
from sim_nodes.pybullet.textures import Textures
from sim_nodes.robots.declaration import ArmDeclaration, RobotDeclaration
from sim_nodes.robots.drive_declaration import DifferentialDrive, DriveDeclaration
from sim_nodes.robots.kinematics import motor_joints, wheel_joints
from sim_nodes.robots.sensor_declarations import ForceTorqueDeclaration
from sim_nodes.robots.urdf_check import link_parts
from sim_nodes.views import Colour

FASTEST = 1e5  # [m/s], [rad/s]; Bullet's default velocity limit is 100, also for bodies without joints
BASE = -1  # Bullet's index of the base link
MAX_LINKS = 128  # of a body; Bullet loses larger ones without an error
JOINT_NAME, JOINT_TYPE, LINK_NAME = 1, 2, 12  # fields of `getJointInfo`
INERTIA = 2  # field of `getDynamicsInfo`
NO_MESHES: Mapping[str, bytes] = MappingProxyType({})
XYZW = tuple[float, float, float, float]  # Bullet's order of quaternions


class Links:
    """Indices of the links and joints of a loaded robot by name; a joint has the index of its child link.

    Args:
        bullet: The Bullet client.
        body: Number of the robot's body.
        robot: Declaration of the robot.
        added: Names of links added for further shapes, with the names of the original links.

    Attributes:
        joints: Indices of joints.
        links: Indices of links.
        shapes: Indices of all links, also added ones, with the names of the original links.
        compound: Links of more than one shape, with their shapes.
    """

    def __init__(self, bullet: Any, body: int, robot: RobotDeclaration, added: Mapping[str, str]) -> None:
        infos = [bullet.getJointInfo(body, index) for index in range(bullet.getNumJoints(body))]
        names = _link_names(bullet, body)
        self.joints: dict[str, int] = {info[JOINT_NAME].decode(): info[0] for info in infos}
        self.links = {name: index for index, name in names.items() if name not in added}
        self.shapes = {index: added.get(name, name) for index, name in names.items()}
        split = added.values()
        parts = link_parts(robot)
        self.compound = {name: parts[name] for name in self.links if len(parts[name]) > 1 and name not in split}


def movable_joints(bullet: Any, body: int) -> tuple[int, ...]:
    """Return the indices of the movable joints of a body."""
    infos = (bullet.getJointInfo(body, index) for index in range(bullet.getNumJoints(body)))
    return tuple(info[0] for info in infos if info[JOINT_TYPE] != bullet.JOINT_FIXED)


def _link_names(bullet: Any, body: int) -> dict[int, str]:
    """Return the names of the links of a body by index; the base is the last."""
    infos = (bullet.getJointInfo(body, index) for index in range(bullet.getNumJoints(body)))
    return {info[0]: info[LINK_NAME].decode() for info in infos} | {BASE: bullet.getBodyInfo(body)[0].decode()}


def xyzw(orientation: Quaternion) -> XYZW:
    """Convert a quaternion to Bullet's order."""
    w, x, y, z = orientation
    return x, y, z, w


def wxyz(orientation: XYZW) -> Quaternion:
    """Convert a quaternion from Bullet's order."""
    x, y, z, w = orientation
    return w, x, y, z


def link_frame(bullet: Any, body: int, link: int) -> tuple[Vector, Quaternion]:
    """Return the position and orientation of a link's frame in `map`."""
    if link != BASE:
        found = bullet.getLinkState(body, link, computeForwardKinematics=True)
        return found[4], wxyz(found[5])
    place, turn = bullet.getBasePositionAndOrientation(body)
    centre, axes = bullet.getDynamicsInfo(body, BASE)[3:5]
    orientation = multiply(wxyz(turn), conjugate(wxyz(axes)))
    return vector(np.subtract(place, rotated(orientation, centre))), orientation


def joint_load(bullet: Any, body: int, link: int) -> tuple[Vector, Vector]:
    """Return the load on the joint of a link: force and torque about the link's origin, in its frame.

    Bullet has the force on the link, and the torque about its centre of mass, in the axes of its inertia.
    """
    reaction = np.array(bullet.getJointState(body, link)[2])
    centre, axes = bullet.getDynamicsInfo(body, link)[3:5]
    turn = rotation_matrix(wxyz(axes))
    force, torque = -turn @ reaction[:3], -turn @ reaction[3:]
    return vector(force), vector(torque + np.cross(centre, force))


def load_robot(bullet: Any, robot: PlacedRobot, textures: Textures) -> tuple[int, Links]:
    """Load a robot; returns its body number and the indices of its links."""
    declaration = robot.declaration
    root = fromstring(declaration.urdf)
    # Arms have links of many shapes, which rarely touch anything; and every link takes time.
    added = split_links(root) if declaration.arm is None and not declaration.fixed else {}
    meshes = dict(declaration.meshes)
    body = _load(bullet, root, robot.state, static=declaration.fixed, meshes=meshes)
    textures.show(body, root, meshes, _link_names(bullet, body))
    links = Links(bullet, body, declaration, added)
    friction = dict.fromkeys(links.links, declaration.body_friction)
    friction |= dict.fromkeys(declaration.low_friction_links, 0.0)
    if declaration.mobile is not None:
        drive = declaration.mobile.drive
        turning = {links.joints[name] for name in wheel_joints(drive)}
        grip = drive.wheel_friction if isinstance(drive, DifferentialDrive) else 0.0
        friction |= {name: grip for name, index in links.links.items() if index in turning}
    for index, name in links.shapes.items():
        bullet.changeDynamics(body, index, lateralFriction=friction[name])
    _undamp(bullet, body)
    if declaration.arm is not None:
        _couple_followers(bullet, body, root, declaration.arm)
    for sensor in declaration.sensors:
        if isinstance(sensor, ForceTorqueDeclaration):
            bullet.enableJointForceTorqueSensor(body, links.links[sensor.link], True)
    return body, links


def _couple_followers(bullet: Any, body: int, urdf: Element, arm: ArmDeclaration) -> None:
    """Let joints of a robot follow those of its arm and its fingers, which are coupled elsewhere."""
    following = {joint.get("name", "") for joint in urdf.findall("joint") if joint.find("mimic") is not None}
    following -= {*arm.home, *arm.fingers}
    if not following:
        return
    opened = 0.0 if arm.gripper is None else arm.gripper.position_of(arm.gripper.stroke)
    couple_mimics(bullet, body, urdf, arm.home | dict.fromkeys(arm.fingers, opened), arm.fingers)
    for joint in movable_joints(bullet, body):
        name = bullet.getJointInfo(body, joint)[JOINT_NAME].decode()
        if name in following:
            bullet.setJointMotorControl2(body, joint, bullet.VELOCITY_CONTROL, force=0.0)
        if arm.gripper is not None and name in {*following, *arm.fingers}:
            # Bullet has no armature; without it, gears hardly hold links of a few grams.
            inertia = np.add(bullet.getDynamicsInfo(body, joint)[INERTIA], arm.gripper.armature)
            bullet.changeDynamics(body, joint, localInertiaDiagonal=inertia.tolist())


def motors(links: Links, drive: DriveDeclaration) -> tuple[int, ...]:
    """Return the joint indices of the motors of a drive."""
    return tuple(links.joints[name] for name in motor_joints(drive))


def load_body(bullet: Any, model: BodyModel, state: BodyState, colour: Colour, textures: Textures) -> int:
    """Load a body; returns its number."""
    root = _urdf(model) if model.urdf is None else fromstring(model.urdf.text)
    _show_solids(root)
    paint(root, colour)
    has_joints = model.urdf is not None and bool(model.urdf.joints)
    # Static bodies stay one link, because every link takes time.
    added = split_links(root) if has_joints or not model.static else {}
    if (count := len(root.findall("link"))) > MAX_LINKS:
        raise RequestRefused(
            SpawnResult.UNSUPPORTED_ASSETS,
            f"the model has {count} links and further shapes of links; PyBullet simulates at most {MAX_LINKS}",
        )
    meshes = NO_MESHES if model.urdf is None else model.urdf.meshes
    body = _load(bullet, root, state, static=model.static, meshes=meshes)
    links = _link_names(bullet, body)
    textures.show(body, root, meshes, links)
    own = {} if model.urdf is None else model.urdf.friction
    for index, name in links.items():
        bullet.changeDynamics(body, index, lateralFriction=own.get(added.get(name, name), model.friction))
    bullet.changeDynamics(body, BASE, maxJointVelocity=FASTEST)
    if has_joints:
        _release(bullet, body, root)
        couple_mimics(bullet, body, root)
    _undamp(bullet, body)
    return body


def _show_solids(urdf: Element) -> None:
    """Add visuals to links without some; Bullet would draw their solid shapes in white."""
    for link in urdf.findall("link"):
        if link.find("visual") is None:
            for collision in link.findall("collision"):
                SubElement(link, "visual").extend(deepcopy(list(collision)))


def _release(bullet: Any, body: int, urdf: Element) -> None:
    """Let the joints of a body move freely, except for their friction: Bullet brakes them by motors."""
    frictions = {
        joint.get("name"): float(dynamics.get("friction", "0"))
        for joint in urdf.findall("joint")
        for dynamics in joint.findall("dynamics")
    }
    for index in range(bullet.getNumJoints(body)):
        info = bullet.getJointInfo(body, index)
        force = frictions.get(info[JOINT_NAME].decode(), 0.0)
        if info[JOINT_TYPE] in (bullet.JOINT_REVOLUTE, bullet.JOINT_PRISMATIC):
            bullet.setJointMotorControl2(body, index, bullet.VELOCITY_CONTROL, targetVelocity=0.0, force=force)
        elif info[JOINT_TYPE] == bullet.JOINT_SPHERICAL:
            bullet.setJointMotorControlMultiDof(
                body,
                index,
                bullet.POSITION_CONTROL,
                targetPosition=[0, 0, 0, 1],
                positionGain=0,
                velocityGain=0,
                force=[force] * 3,
            )


def _undamp(bullet: Any, body: int) -> None:
    """Remove the damping of a body; in a call with friction, Bullet would apply that to the base only."""
    bullet.changeDynamics(body, BASE, linearDamping=0.0, angularDamping=0.0)


def _load(
    bullet: Any, urdf: Element, state: BodyState, *, static: bool = False, meshes: Mapping[str, bytes] = NO_MESHES
) -> int:
    # Convex hulls instead of cylinders would make wheels polygons, and robots 3 % too fast.
    flags = bullet.URDF_USE_INERTIA_FROM_FILE | bullet.URDF_USE_IMPLICIT_CYLINDER
    with tempfile.TemporaryDirectory(prefix="seoro-") as folder, captured_output():
        path = Path(folder) / "model.urdf"
        # Bullet breaks lines after 8 KiB, even within a word.
        text = tostring(urdf, encoding="unicode")
        path.write_text(text.replace("><", ">\n<"), encoding="utf-8")
        for name, data in meshes.items():
            (path.parent / name).write_bytes(data)
        body: int = bullet.loadURDF(
            str(path), state.position, xyzw(state.orientation), useFixedBase=static, flags=flags
        )
    return body


def _urdf(model: BodyModel) -> Element:
    root = Element("robot", name="body")
    link = SubElement(root, "link", name="body")
    spread = inertia(model)
    inertial = SubElement(link, "inertial")
    write_origin(inertial, spread.centre, roll_pitch_yaw(spread.axes))
    SubElement(inertial, "mass", value=repr(model.mass))
    ixx, iyy, izz = map(repr, spread.moments)
    SubElement(inertial, "inertia", ixx=ixx, iyy=iyy, izz=izz, ixy="0", ixz="0", iyz="0")
    for part in model.parts:
        collision = SubElement(link, "collision")
        write_origin(collision, part.position, roll_pitch_yaw(part.orientation))
        write_shape(SubElement(collision, "geometry"), part.shape)
    return root


SPECK = "1e-5 1e-5 1e-5"  # [m] visual of an added link; without one, Bullet renders the collision shape


def split_links(root: Element) -> dict[str, str]:
    """Give every collision shape of a URDF its own link; returns the original links by added ones."""
    added = {}
    for link in root.findall("link"):
        name = link.get("name", "")
        for index, collision in enumerate(link.findall("collision")[1:], 1):
            part = f"{name}#{index}"
            link.remove(collision)
            _add(root, link, part).append(collision)
            added[part] = name
    return added


def _add(root: Element, link: Element, name: str) -> Element:
    """Add a massless link that is fixed to another."""
    new = SubElement(root, "link", name=name)
    inertial = SubElement(new, "inertial")
    SubElement(inertial, "mass", value="0")
    SubElement(inertial, "inertia", ixx="0", iyy="0", izz="0", ixy="0", ixz="0", iyz="0")
    if link.find("visual") is not None:
        SubElement(SubElement(SubElement(new, "visual"), "geometry"), "box", size=SPECK)
    joint = SubElement(root, "joint", name=name, type="fixed")
    SubElement(joint, "parent", link=link.get("name", ""))
    SubElement(joint, "child", link=name)
    return new
