"""Writes compiled models of MuJoCo as URDF, from which other engines load them and parts of bodies are read."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import field
from typing import Any
from xml.etree.ElementTree import Element, SubElement

import mujoco
import numpy as np
import trimesh

from seoro.deferred import dataclass
from sim_nodes.geometry import Array, Quaternion, roll_pitch_yaw, rotated, vector
from sim_nodes.models import xml_reading as xml
from sim_nodes.models.meshes import Mesh, to_stl
from sim_nodes.models.obj import to_obj
from sim_nodes.models.urdf import FIELD, WORLD_LINK, text_of, write_joint, write_origin
from sim_nodes.mujoco.actuation import efforts_of
from sim_nodes.mujoco.couplings import Couplings, find_couplings
from sim_nodes.mujoco.specs import WORLD, body_name, joint_name
from sim_nodes.mujoco.textures import (
    mean_tint,
    picture,
    shows_on_shape,
    shows_picture,
    texture_of,
    textured_mesh,
)

HINGE, SLIDE = int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE)
BALL, FREE = int(mujoco.mjtJoint.mjJNT_BALL), int(mujoco.mjtJoint.mjJNT_FREE)
GEOM = mujoco.mjtGeom
SMALL_MASS, SMALL_INERTIA = "1e-4", "1e-7"  # [kg], [kg m^2] of links between two joints of a body
INVISIBLE = 0.01  # opacity below which a geom is a helper of the author


@dataclass
class _Writer:
    model: Any
    out: Element
    efforts: Mapping[int, float]
    couplings: Couplings
    files: dict[str, bytes] = field(default_factory=dict)


@dataclass(frozen=True)
class WrittenUrdf:
    """A model as URDF: its root element, its meshes by virtual path, and parts without effect."""

    urdf: Element
    meshes: Mapping[str, bytes]
    notes: tuple[str, ...]


def urdf_of(model: Any) -> WrittenUrdf:
    """Write the body of a model as URDF.

    Planes of the world are left out: they are floors of demonstrations. Positions of joints are from their initial
    ones in the model.

    Args:
        model: MuJoCo's model, with one free body at the top, or with all bodies on the world.
    """
    writer = _Writer(model, Element("robot", name="model"), efforts_of(model), find_couplings(model))
    tops = tops_of(model)
    if tops and is_free(model, tops[0]):
        _add_body(writer, tops[0], parent=None)
    else:
        base = SubElement(writer.out, "link", name=WORLD_LINK)
        SubElement(SubElement(base, "inertial"), "mass", value="0")
        _add_geoms(writer, base, WORLD, np.zeros(3), shapes_of_world(model))
        for body in tops:
            _add_body(writer, body, parent=WORLD_LINK)
    return WrittenUrdf(writer.out, writer.files, tuple(writer.couplings.notes))


def tops_of(model: Any) -> list[int]:
    """Return the numbers of the bodies at the top."""
    return [body for body in range(1, model.nbody) if model.body_parentid[body] == WORLD]


def shapes_of_world(model: Any) -> list[int]:
    """Return the numbers of the geoms of the world except floors."""
    return [geom for geom in _geoms(model, WORLD) if model.geom_type[geom] != GEOM.mjGEOM_PLANE]


def is_free(model: Any, body: int) -> bool:
    """Whether a body at the top moves freely."""
    joints = _joints(model, body)
    return bool(joints) and model.jnt_type[joints[0]] == FREE


def _joints(model: Any, body: int) -> list[int]:
    start = int(model.body_jntadr[body])
    return list(range(start, start + int(model.body_jntnum[body])))


def _geoms(model: Any, body: int) -> list[int]:
    start = int(model.body_geomadr[body])
    return list(range(start, start + int(model.body_geomnum[body])))


def _add_body(writer: _Writer, body: int, parent: str | None, moved: Array | None = None) -> None:
    """Add a body and its descendants.

    Args:
        writer: Writer of the model.
        body: Number of the body.
        parent: Link of the parent; None for a free body.
        moved: Origin of the parent link in the frame of the parent body, shape (3,) [m].
    """
    model = writer.model
    name = body_name(model, body)
    joints = [] if parent is None else _joints(model, body)
    position = model.body_pos[body] - (np.zeros(3) if moved is None else moved)
    orientation: Quaternion = tuple(model.body_quat[body].tolist())
    anchor = np.zeros(3)
    link = name
    for index, joint in enumerate(joints):
        last = index == len(joints) - 1
        child = name if last else f"{name}__{index}"
        at = model.jnt_pos[joint]
        origin = position + np.array(rotated(orientation, vector(at))) if index == 0 else at - anchor
        turn = orientation if index == 0 else (1.0, 0.0, 0.0, 0.0)
        link = _add_link(writer, child, empty=not last)
        _add_joint(writer, joint, str(parent), child, origin, turn)
        parent, anchor = child, at
    if not joints:
        link = _add_link(writer, name, empty=False)
        if parent is not None:
            frame = (vector(position), orientation)
            write_joint(writer.out, f"{name}__fixed", "fixed", parent, name, frame)
    _add_inertial(model, link, body, anchor)
    _add_geoms(writer, link, body, anchor, _geoms(model, body))
    for below in range(body + 1, model.nbody):
        if model.body_parentid[below] == body:
            _add_body(writer, below, name, anchor)


def _add_link(writer: _Writer, name: str, *, empty: bool) -> Any:
    link = SubElement(writer.out, "link", name=name)
    if empty:
        inertial = SubElement(link, "inertial")
        SubElement(inertial, "mass", value=SMALL_MASS)
        SubElement(inertial, "inertia", ixx=SMALL_INERTIA, iyy=SMALL_INERTIA, izz=SMALL_INERTIA)
    return link


def _add_inertial(model: Any, link: Any, body: int, anchor: Array) -> None:
    mass = float(model.body_mass[body])
    if mass <= 0.0:
        return
    inertial = SubElement(link, "inertial")
    write_origin(inertial, model.body_ipos[body] - anchor, roll_pitch_yaw(tuple(model.body_iquat[body].tolist())))
    SubElement(inertial, "mass", value=repr(mass))
    ixx, iyy, izz = (repr(value) for value in model.body_inertia[body].tolist())
    SubElement(inertial, "inertia", ixx=ixx, iyy=iyy, izz=izz)


def _add_joint(writer: _Writer, joint: int, parent: str, child: str, origin: Array, turn: Quaternion) -> None:
    model = writer.model
    kind, limited = int(model.jnt_type[joint]), bool(model.jnt_limited[joint])
    types = {
        HINGE: "revolute" if limited else "continuous",
        SLIDE: "prismatic",
        BALL: "spherical",
        FREE: "floating",
    }
    element = write_joint(writer.out, joint_name(model, joint), types[kind], parent, child, (vector(origin), turn))
    if kind not in (HINGE, SLIDE):
        return
    SubElement(element, "axis", xyz=text_of(model.jnt_axis[joint]))
    initial = float(model.qpos0[model.jnt_qposadr[joint]])
    low, high = (model.jnt_range[joint] - initial).tolist() if limited else (-1e3, 1e3)
    effort = writer.efforts.get(joint, math.inf)
    known = {"effort": repr(effort if math.isfinite(effort) else 0.0), "velocity": "0"}
    SubElement(element, "limit", {"lower": repr(low), "upper": repr(high), **known})
    dof = int(model.jnt_dofadr[joint])
    values = {"damping": model.dof_damping[dof], "friction": model.dof_frictionloss[dof]}
    SubElement(element, "dynamics", {key: repr(float(value.item())) for key, value in values.items()})
    coupling = writer.couplings.of.get(joint)
    if coupling is not None:
        line = {"multiplier": repr(coupling.factor), "offset": repr(coupling.offset)}
        SubElement(element, "mimic", {"joint": joint_name(model, coupling.leader)} | line)


def _add_geoms(writer: _Writer, link: Any, body: int, anchor: Array, geoms: list[int]) -> None:
    model = writer.model
    solids = [geom for geom in geoms if model.geom_contype[geom] or model.geom_conaffinity[geom]]
    if solids:
        friction = repr(float(model.geom_friction[solids[0]][0]))
        SubElement(SubElement(link, "contact"), "lateral_friction", value=friction)
    for geom in geoms:
        solid = bool(model.geom_contype[geom] or model.geom_conaffinity[geom])
        seen = float(model.geom_rgba[geom][3]) > INVISIBLE
        for purpose in (["collision"] if solid else []) + (["visual"] if seen else []):
            element = SubElement(link, purpose)
            write_origin(
                element, model.geom_pos[geom] - anchor, roll_pitch_yaw(tuple(model.geom_quat[geom].tolist()))
            )
            if purpose == "visual":
                _add_appearance(writer, element, geom)
            else:
                _add_shape(writer, SubElement(element, "geometry"), geom)


def _add_appearance(writer: _Writer, visual: Any, geom: int) -> None:
    """Add shape and colour of a visual; textures of shapes that cannot show them have their mean colour."""
    model = writer.model
    material, texture = int(model.geom_matid[geom]), texture_of(model, geom)
    colour = np.array(model.geom_rgba[geom] if material < 0 else model.mat_rgba[material])
    geometry = SubElement(visual, "geometry")
    own = SubElement(visual, "material", name="")
    if texture is not None and shows_picture(model, geom):
        SubElement(own, "texture", filename=_add_picture(writer, geometry, int(model.geom_dataid[geom]), texture))
    else:
        _add_shape(writer, geometry, geom)
        if texture is not None and shows_on_shape(model, geom):
            SubElement(own, "texture", filename=_picture_file(writer, texture))
        elif texture is not None:
            colour[:3] *= mean_tint(model, texture)
    SubElement(own, "color", rgba=text_of(colour))


def _add_picture(writer: _Writer, out: Any, mesh: int, texture: int) -> str:
    """Add a mesh with a picture; returns the path of the picture."""
    path = f"textured_{mesh}.obj"
    if path not in writer.files:
        writer.files[path] = to_obj(textured_mesh(writer.model, mesh))
    SubElement(out, "mesh", filename=path)
    return _picture_file(writer, texture)


def _picture_file(writer: _Writer, texture: int) -> str:
    """Return the path of a texture in a file."""
    path = f"texture_{texture}.png"
    if path not in writer.files:
        writer.files[path] = picture(writer.model, texture)
    return path


def _add_shape(writer: _Writer, out: Any, geom: int) -> None:
    model = writer.model
    x, y, z = model.geom_size[geom].tolist()
    match model.geom_type[geom]:
        case GEOM.mjGEOM_BOX:
            SubElement(out, "box", size=text_of((2 * x, 2 * y, 2 * z)))
        case GEOM.mjGEOM_SPHERE:
            SubElement(out, "sphere", radius=repr(x))
        case GEOM.mjGEOM_CYLINDER:
            SubElement(out, "cylinder", radius=repr(x), length=repr(2 * y))
        case GEOM.mjGEOM_CAPSULE:
            SubElement(out, "capsule", radius=repr(x), length=repr(2 * y))
        case GEOM.mjGEOM_PLANE:
            SubElement(out, "plane")
        case GEOM.mjGEOM_ELLIPSOID:
            ball = trimesh.creation.icosphere(2)
            _add_mesh(writer, out, f"ellipsoid_{geom}", ball.vertices * (x, y, z), ball.faces)
        case GEOM.mjGEOM_MESH:
            mesh = int(model.geom_dataid[geom])
            first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
            start, faces = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
            _add_mesh(
                writer,
                out,
                f"mesh_{mesh}",
                model.mesh_vert[first : first + count],
                model.mesh_face[start : start + faces],
            )
        case GEOM.mjGEOM_HFIELD:
            _add_field(writer, out, geom)
        case other:
            raise xml.invalid(f"unsupported geom of type {other} in another engine than MuJoCo")


def _add_mesh(writer: _Writer, out: Any, name: str, vertices: Array, faces: Any) -> None:
    path = f"{name}.stl"
    if path not in writer.files:
        writer.files[path] = to_stl(Mesh(vertices, faces))
    SubElement(out, "mesh", filename=path)


def _add_field(writer: _Writer, out: Any, geom: int) -> None:
    """Add a height field as a mesh."""
    model = writer.model
    index = int(model.geom_dataid[geom])
    rows, columns = int(model.hfield_nrow[index]), int(model.hfield_ncol[index])
    start = int(model.hfield_adr[index])
    x, y, top, _ = model.hfield_size[index].tolist()
    heights = model.hfield_data[start : start + rows * columns].reshape(rows, columns) * top
    grid = np.stack(np.meshgrid(np.linspace(-x, x, columns), np.linspace(-y, y, rows)), axis=-1)
    vertices = np.concatenate([grid, heights[..., None]], axis=-1).reshape(-1, 3)
    corner = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    faces = np.concatenate(
        [
            np.stack([corner, corner + 1, corner + columns], 1),
            np.stack([corner + 1, corner + columns + 1, corner + columns], 1),
        ]
    )
    _add_mesh(writer, out, f"field_{index}", vertices, faces)
    out[-1].set(FIELD, "true")
