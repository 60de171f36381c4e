"""Bodies from model files in MuJoCo: its compiler reads URDF and MJCF, and the result is attached to the scene."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations
from typing import Any

import mujoco
from defusedxml import ElementTree

from sim_nodes.models.urdf import paint, pictures_of
from sim_nodes.mujoco.groups import HIDDEN_GROUP, SOLID_GROUP, VISUAL_GROUP
from sim_nodes.physics import BodyModel, Mjcf, Urdf
from sim_nodes.views import Colour, colour_of

GREY = (0.5, 0.5, 0.5, 1.0)  # MuJoCo's colour of geoms without one
ASSETS = ("meshes", "textures", "materials", "hfields", "skins")


def attach_file(spec: Any, body: Any, name: str, model: BodyModel) -> None:
    """Attach the file of a model to a body.

    Args:
        spec: Specification of the scene.
        body: Body of the entity in it, which gets the content of the file.
        name: Name of the entity; names of the file get it as a prefix.
        model: Model with a file.
    """
    assert model.urdf is not None
    colour = colour_of(name, model.colour)
    child = _urdf_spec(model.urdf, colour) if model.mjcf is None else _mjcf_spec(model.mjcf)
    for mesh in child.meshes:
        mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL  # bodies have their own; flat meshes are allowed
    share_options(child, spec)
    show_visuals(child, colour)
    spec.attach(child, prefix=f"{name}/", frame=body.add_frame())


def share_options(child: Any, spec: Any) -> None:
    """Give a specification the options of the scene that it is attached to, which count."""
    for option in (each for each in dir(spec.option) if not each.startswith("_")):
        setattr(child.option, option, getattr(spec.option, option))


def detach_file(spec: Any, name: str) -> None:
    """Remove the assets of an entity, whose body was removed, so that its name can be used again."""
    prefix = f"{name}/"
    for kind in ASSETS:
        for asset in [asset for asset in getattr(spec, kind) if asset.name.startswith(prefix)]:
            spec.delete(asset)


def _urdf_spec(urdf: Urdf, colour: Colour) -> Any:
    """Return the specification of a URDF; its links do not collide with each other, as in Gazebo and PyBullet."""
    root = ElementTree.fromstring(urdf.text)
    paint(root, colour)
    spec = urdf_spec(root, urdf.meshes)
    bodies = [body for body in spec.bodies if body.name != "world"]
    for body in bodies:
        for geom in body.geoms:
            if geom.contype and body.name in urdf.friction:
                geom.friction[0] = urdf.friction[body.name]
    solid = [body.name for body in bodies if any(geom.contype for geom in body.geoms)]
    for first, second in combinations(solid, 2):
        spec.add_exclude(bodyname1=first, bodyname2=second)
    return spec


def _mjcf_spec(mjcf: Mjcf) -> Any:
    """Return the specification of an MJCF file without floor and free joint, which its entity has."""
    spec = mujoco.MjSpec.from_string(mjcf.text, assets=dict(mjcf.assets))
    world = spec.worldbody
    for plane in [geom for geom in world.geoms if geom.type == mujoco.mjtGeom.mjGEOM_PLANE]:
        spec.delete(plane)
    for light in list(world.lights):
        spec.delete(light)
    for body in spec.bodies:
        body.mocap = False  # only bodies of the world may be, and the entity is one
    for body in list(world.bodies):
        for joint in [joint for joint in body.joints if joint.type == mujoco.mjtJoint.mjJNT_FREE]:
            spec.delete(joint)
            body.pos, body.quat = [0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]
    for key in list(spec.keys):
        spec.delete(key)
    return spec


def show_visuals(spec: Any, colour: Colour) -> None:
    """Show visuals instead of solid shapes where a body has both, and give solid shapes without a colour one."""
    for body in spec.bodies:
        solids = [geom for geom in body.geoms if geom.contype or geom.conaffinity]
        visuals = [geom for geom in body.geoms if not (geom.contype or geom.conaffinity)]
        for geom in solids:
            geom.group = HIDDEN_GROUP if visuals else SOLID_GROUP
        for geom in visuals:
            geom.group = VISUAL_GROUP
        for geom in solids:
            if not geom.material and tuple(geom.rgba.tolist()) == GREY:
                geom.rgba = colour


def urdf_spec(root: Any, files: Mapping[str, bytes]) -> Any:
    """Return the specification of a canonical URDF, with its pictures, which MuJoCo's reader drops.

    By default, MuJoCo also drops visuals and links at fixed joints.

    Args:
        root: Root element, which is changed.
        files: Meshes and pictures by file name.
    """
    extension = root.makeelement("mujoco", {})
    extension.append(root.makeelement("compiler", {"discardvisual": "false", "fusestatic": "false"}))
    root.insert(0, extension)
    spec = mujoco.MjSpec.from_string(ElementTree.tostring(root, encoding="unicode"), assets=dict(files))
    solid = {geom.meshname for geom in spec.geoms if geom.contype}
    for mesh in spec.meshes:
        if mesh.name not in solid:
            mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL  # allows flat ones
    _add_pictures(spec, pictures_of(root))
    return spec


def _add_pictures(spec: Any, pictures: Mapping[str, str]) -> None:
    """Add the pictures of meshes, given by the names of their files."""
    materials: dict[tuple[str, tuple[float, ...]], str] = {}
    for geom in spec.geoms if pictures else ():
        picture = pictures.get(spec.mesh(geom.meshname).file) if geom.meshname else None
        if picture is None:
            continue
        if spec.texture(picture) is None:
            spec.add_texture(name=picture, type=mujoco.mjtTexture.mjTEXTURE_2D, file=picture)
        key = picture, tuple(geom.rgba.tolist())
        if key not in materials:
            textures = [""] * mujoco.mjtTextureRole.mjNTEXROLE.value
            textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = picture
            materials[key] = f"{picture}/{len(materials)}"
            spec.add_material(name=materials[key], textures=textures, rgba=geom.rgba)
        geom.material = materials[key]
