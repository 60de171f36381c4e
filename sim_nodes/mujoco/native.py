"""Robots in MuJoCo from their own MJCF files, with what their declarations change.

A file keeps its shapes, contacts, equalities, tendons, and the friction and damping of joints. Its actuators,
sensors, cameras, lights, keyframes and floor are left out: motors and sensors are those of the declaration. The
URDF of the declaration, which was written from the same file, has the names and limits of joints.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import Any
from xml.etree.ElementTree import SubElement

import mujoco
from defusedxml import ElementTree

from sim_nodes.geometry import Frame
from sim_nodes.models.urdf import WORLD_LINK, frame_of, read_origin, text_of
from sim_nodes.mujoco.actuation import joints_of_tendon
from sim_nodes.mujoco.files import show_visuals
from sim_nodes.mujoco.specs import WORLD, body_name, compile_spec, joint_name
from sim_nodes.physics import Mjcf
from sim_nodes.robots.declaration import NativeModel, RobotDeclaration
from sim_nodes.robots.kinematics import wheel_joints
from sim_nodes.views import colour_of

REPLACED = ("actuators", "sensors", "keys", "cameras", "lights")
FRAME_MASS, FRAME_INERTIA = "1e-3", "1e-6 1e-6 1e-6"  # [kg], [kg m^2] of a base that is not in the file


def keyframes_of(mjcf: Mjcf) -> dict[str, dict[str, float]]:
    """Return the named keyframes of a file: positions by joint, from their initial ones [rad], [m]."""
    model = compile_spec(mujoco.MjSpec.from_string(mjcf.text, assets=dict(mjcf.assets)))
    joints = [each for each in range(model.njnt) if model.jnt_type[each] in (HINGE, SLIDE)]
    addresses = {joint_name(model, joint): int(model.jnt_qposadr[joint]) for joint in joints}
    return {
        str(model.key(key).name): {
            joint: float(model.key_qpos[key, address] - model.qpos0[address])
            for joint, address in addresses.items()
        }
        for key in range(model.nkey)
        if model.key(key).name
    }


HINGE, SLIDE = int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE)


def native_spec(declaration: RobotDeclaration, native: NativeModel) -> Any:
    """Return the specification of a robot from its own file, without motors and a free joint."""
    urdf, assets = ElementTree.fromstring(declaration.urdf), dict(native.assets)
    original = mujoco.MjSpec.from_string(native.text, assets=assets)
    model = compile_spec(original)  # numbers bodies, joints and tendons
    has_base = any(body_name(model, body) == declaration.base_link for body in range(model.nbody))
    text = native.text if has_base else _with_base(native.text, declaration.base_link, urdf)
    spec = mujoco.MjSpec.from_string(text, assets=assets)
    _name_all(spec, original, model)
    _strip(spec)
    joints = {str(each.get("name")): each for each in urdf.findall("joint")}
    _remove_joints(spec, model, {name for name, each in joints.items() if each.get("type") == "fixed"})
    for joint in spec.joints:
        if joint.name in joints:
            _adapt_joint(joint, joints[joint.name], 180.0 / math.pi if spec.compiler.degree else 1.0)
    _make_solid(spec)
    _make_round(spec, declaration, urdf)
    _move_to_origin(spec, urdf)
    show_visuals(spec, colour_of(declaration.model, None))
    return spec


def _with_base(text: str, base_link: str, urdf: Any) -> str:
    """Return the text of a file with a further body, the base, which has all others at the frame of the URDF."""
    root = ElementTree.fromstring(text)
    worlds = root.findall("worldbody")
    content = [each for world in worlds for each in world]
    place, (w, x, y, z) = _frame_of_file(urdf)
    base = SubElement(worlds[0], "body", name=base_link)
    SubElement(base, "inertial", pos="0 0 0", mass=FRAME_MASS, diaginertia=FRAME_INERTIA)
    frame = SubElement(base, "frame", pos=text_of(place), quat=text_of((w, x, y, z)))
    frame.extend(content)
    for world in worlds:
        for each in [each for each in world if each is not base]:
            world.remove(each)
    return ElementTree.tostring(root, encoding="unicode")


def _frame_of_file(urdf: Any) -> Frame:
    """Return the frame of the world, or of the only body at the top, in that of the base."""
    links = [str(each.get("name")) for each in urdf.findall("link")]
    hung = {
        str(joint.find("child").get("link")): (str(joint.find("parent").get("link")), read_origin(joint))
        for joint in urdf.findall("joint")
    }
    return frame_of(WORLD_LINK if WORLD_LINK in links else _top_of(urdf), hung)


def _top_of(urdf: Any) -> str:
    """Return the first link of a URDF, that of the body at the top of its file."""
    return str(urdf.find("link").get("name"))


def _move_to_origin(spec: Any, urdf: Any) -> None:
    """Move the only body at the top of a file to its origin, if the URDF has no link of the world."""
    top = spec.body(_top_of(urdf))
    if top.name == WORLD_LINK:
        return
    top.pos, top.quat = [0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]
    top.alt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT


def _name_all(spec: Any, original: Any, model: Any) -> None:
    """Give bodies and joints without a name those of the URDF; the base may be a further body."""
    own = [body for body in original.bodies if body.id != WORLD]
    for body, known in zip(list(spec.bodies)[-len(own) :], own, strict=True):
        body.name = body_name(model, known.id)
    for joint, known in zip(spec.joints, original.joints, strict=True):
        joint.name = joint_name(model, known.id)


def _strip(spec: Any) -> None:
    """Remove what robots have by their declarations, and the floor."""
    planes = [geom for geom in spec.geoms if geom.type == mujoco.mjtGeom.mjGEOM_PLANE]
    free = [joint for joint in spec.joints if joint.type == mujoco.mjtJoint.mjJNT_FREE]
    for element in (*(each for kind in REPLACED for each in getattr(spec, kind)), *planes, *free):
        spec.delete(element)
    for body in spec.bodies:
        body.mocap = False  # only bodies of the world may be


def _remove_joints(spec: Any, model: Any, held: Collection[str]) -> None:
    """Remove joints that the URDF holds, and the tendons and equalities that they are part of."""
    gone = [joint for joint in spec.joints if joint.name in held]
    tendons = [
        tendon
        for number, tendon in enumerate(spec.tendons)
        if any(joint_name(model, joint) in held for joint, _ in joints_of_tendon(model, number))
    ]
    names = {each.name for each in (*gone, *tendons)}
    kinds = (int(mujoco.mjtEq.mjEQ_JOINT), int(mujoco.mjtEq.mjEQ_TENDON))
    of_joints = [each for each in spec.equalities if int(each.type) in kinds]
    equalities = [each for each in of_joints if names.intersection((each.name1, each.name2))]
    for element in (*equalities, *tendons, *gone):
        spec.delete(element)


def _adapt_joint(joint: Any, element: Any, degrees: float) -> None:
    """Give a joint the direction, the limits and the zero of its URDF.

    Args:
        joint: The joint.
        element: Its element.
        degrees: Unit of angles in the file by radians.
    """
    unit = degrees if int(joint.type) == HINGE else 1.0
    axis, limit = element.find("axis"), element.find("limit")
    joint.springref, joint.ref = joint.springref - joint.ref, 0.0
    if axis is not None:
        wanted = [float(each) for each in axis.get("xyz").split()]
        if sum(a * b for a, b in zip(wanted, joint.axis.tolist(), strict=True)) < 0.0:
            joint.axis, joint.springref = wanted, -joint.springref
    limits: Mapping[str, str] = {} if limit is None else limit.attrib
    if "lower" in limits and "upper" in limits:
        joint.limited = mujoco.mjtLimited.mjLIMITED_TRUE
        joint.range = [unit * float(limits[key]) for key in ("lower", "upper")]
    if "effort" in limits:
        effort = float(limits["effort"])
        joint.actfrclimited, joint.actfrcrange = mujoco.mjtLimited.mjLIMITED_TRUE, [-effort, effort]


def _make_solid(spec: Any) -> None:
    """Let all solid shapes touch all others; files may limit contacts to their own shapes."""
    for geom in spec.geoms:
        if geom.contype or geom.conaffinity:
            geom.contype = geom.conaffinity = 1


def _make_round(spec: Any, declaration: RobotDeclaration, urdf: Any) -> None:
    """Give wheels with meshes the cylinders of the URDF, on which they roll."""
    if declaration.mobile is None:
        return
    wheels = wheel_joints(declaration.mobile.drive)
    links = {str(each.get("name")): each for each in urdf.findall("link")}
    for joint in (each for each in urdf.findall("joint") if each.get("name") in wheels):
        link = links[joint.find("child").get("link")]
        body = spec.body(link.get("name"))
        solids = [geom for geom in body.geoms if geom.contype]
        collisions = link.findall("collision")
        is_round = all(each.find("geometry/cylinder") is not None for each in collisions)
        if len(collisions) != 1 or not is_round or not any(_is_mesh(geom) for geom in solids):
            continue
        [collision] = collisions
        for geom in solids:
            geom.contype = geom.conaffinity = 0
        place, turn = read_origin(collision)
        shape = collision.find("geometry/cylinder")
        size = [float(shape.get("radius")), float(shape.get("length")) / 2.0, 0.0]
        body.add_geom(type=mujoco.mjtGeom.mjGEOM_CYLINDER, size=size, pos=place, quat=turn, mass=0.0)


def _is_mesh(geom: Any) -> bool:
    return bool(geom.type == mujoco.mjtGeom.mjGEOM_MESH)
