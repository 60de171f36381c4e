"""Models in SDF (http://sdformat.org): one link made of boxes, cylinders and spheres.

What cannot be simulated here is refused by name rather than left out: joints, nested models, plugins, sensors,
meshes, friction that differs by direction or shape. Pictures show the collision shapes, opaque, in the diffuse
colour of the first visual that has one; what else visuals have is allowed without effect, as are the matrix of
inertia, which follows from mass and shapes here, and switches that mean nothing for a single link.
"""

from __future__ import annotations

import math
from typing import Any

from sim_nodes.colours import Colour
from sim_nodes.geometry import quaternion
from sim_nodes.models.reading import (
    FRICTIONS,
    INERTIAS,
    MASSES,
    MAX_PARTS,
    ORIGIN,
    PLACES,
    SIZES,
    Frame,
    check_children,
    check_inertia,
    inside,
    no_meshes,
    numbers,
    read_colour,
    symmetric,
    wrong,
)
from sim_nodes.physics import BodyModel, Box, Cylinder, Part, Shape, Sphere

MODEL_ELEMENTS = frozenset({"static", "link", "pose", "self_collide", "allow_auto_disable"})
LINK_ELEMENTS = frozenset({"pose", "inertial", "collision", "visual", "self_collide"})
INERTIAL_ELEMENTS = frozenset({"mass", "inertia"})
COLLISION_ELEMENTS = frozenset({"pose", "geometry", "surface"})
SURFACE_ELEMENTS = {"surface": frozenset({"friction"}), "friction": frozenset({"ode"}), "ode": frozenset({"mu"})}


def read_sdf(root: Any, *, static: bool) -> BodyModel:
    """The body that an SDF file describes.

    Args:
        root: Its root element.
        static: Whether it is to stand fixed, whatever the file says.

    Raises:
        RequestRefused: It has something that is not supported.
    """
    if root.find("world") is not None:
        raise wrong("the SDF file has a <world>: only files with one <model> directly under <sdf> are read")
    models = root.findall("model")
    if len(models) != 1:
        raise wrong(f"the SDF file has {len(models)} models directly under <sdf>: it has to have one")
    return _model(models[0], static=static)


def _model(model: Any, *, static: bool) -> BodyModel:
    check_children(model, MODEL_ELEMENTS)
    links = model.findall("link")
    if len(links) != 1:
        raise wrong(f"<model> has {len(links)} links: models of one link are supported")
    link = links[0]
    check_children(link, LINK_ELEMENTS)
    frame = inside(_pose(model), _pose(link))
    collisions = link.findall("collision")
    if not 1 <= len(collisions) <= MAX_PARTS:
        raise wrong(f"<link> has {len(collisions)} <collision> elements: it has to have 1 to {MAX_PARTS}")
    parts = tuple(_part(collision, frame) for collision in collisions)
    for inertial in link.findall("inertial"):
        check_children(inertial, INERTIAL_ELEMENTS)
        for inertia in inertial.findall("inertia"):
            _check_inertia(inertia)
    frictions = {_friction(collision) for collision in collisions}
    if len(frictions) > 1:
        raise wrong("the collisions of <link> have different friction: give all the same")
    return BodyModel(
        parts,
        mass=_number(link.find("inertial/mass"), MASSES, 1.0),
        friction=frictions.pop(),
        static=static or _truth(model.find("static")),
        colour=_colour(link.find("visual/material/diffuse")),
    )


def _friction(collision: Any) -> float:
    """The coefficient of sliding friction, `surface/friction/ode/mu`."""
    check_children(collision, COLLISION_ELEMENTS)
    element = collision.find("surface")
    while element is not None and element.tag != "mu":
        check_children(element, SURFACE_ELEMENTS[element.tag])
        element = next(iter(element), None)
    return _number(element, FRICTIONS, 1.0)


def _colour(diffuse: Any) -> Colour | None:
    return None if diffuse is None else read_colour(diffuse.text, "<diffuse>")


def _check_inertia(inertia: Any) -> None:
    """Refuse what no body has, although inertia follows from mass and shapes here."""
    usual = {"ixx": "1", "iyy": "1", "izz": "1"}  # as the specification of SDF has it
    names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    values = [inertia.findtext(name, usual.get(name, "0")) for name in names]
    check_inertia("<link>", symmetric(numbers(" ".join(values), "<inertia>", 6, INERTIAS)))


def _part(collision: Any, frame: Frame) -> Part:
    position, orientation = inside(frame, _pose(collision))
    return Part(_shape(collision.find("geometry")), position, orientation)


def _shape(geometry: Any) -> Shape:
    children = [] if geometry is None else list(geometry)
    if len(children) != 1:
        raise wrong("<collision> has to have a <geometry> with one shape in it")
    shape = children[0]
    match shape.tag:
        case "box":
            x, y, z = _numbers(shape.find("size"), "size", 3, SIZES)
            return Box((x, y, z))
        case "cylinder":
            return Cylinder(_required(shape, "radius"), _required(shape, "length"))
        case "sphere":
            return Sphere(_required(shape, "radius"))
        case "mesh":
            raise no_meshes("box, cylinder or sphere")
        case other:
            raise wrong(f"<geometry> contains <{other}>: it may contain <box>, <cylinder> or <sphere>")


def _required(shape: Any, name: str) -> float:
    return _numbers(shape.find(name), name, 1, SIZES)[0]


def _pose(element: Any) -> Frame:
    pose = element.find("pose")
    if pose is None or not (pose.text or "").strip():
        return ORIGIN
    if pose.get("relative_to"):
        raise wrong(f"<pose relative_to={pose.get('relative_to')!r}> is not supported: leave relative_to out")
    if pose.get("rotation_format", "euler_rpy") != "euler_rpy":
        raise wrong("<pose> is supported as x y z roll pitch yaw only")
    x, y, z, *angles = _numbers(pose, "pose", 6, PLACES)
    scale = math.pi / 180.0 if pose.get("degrees") in ("true", "1") else 1.0
    roll, pitch, yaw = (angle * scale for angle in angles)
    return (x, y, z), quaternion(roll, pitch, yaw)


def _number(element: Any, bounds: tuple[float, float], default: float | None = None) -> float:
    if element is None and default is not None:
        return default
    return _numbers(element, "value" if element is None else element.tag, 1, bounds)[0]


def _numbers(element: Any, name: str, count: int, bounds: tuple[float, float]) -> list[float]:
    return numbers(None if element is None else element.text, f"<{name}>", count, bounds)


def _truth(element: Any) -> bool:
    text = "false" if element is None else (element.text or "").strip()
    if text not in ("true", "false", "1", "0"):
        raise wrong(f"<{element.tag}> is {text!r}: it has to be true or false")
    return text in ("true", "1")
