"""Models in SDF (http://sdformat.org): one link made of boxes, cylinders and spheres.

Unsupported parts are refused by name: joints, nested models, plugins, sensors, meshes, friction that differs by
direction or shape. Images show the collision shapes, opaque, in the diffuse colour of the first visual that has
one. Accepted without effect are other parts of visuals, the inertia matrix, which follows from mass and shapes
here, and switches that do not affect a single link.
"""

from __future__ import annotations

import math
from typing import Any

from sim_nodes.geometry import quaternion
from sim_nodes.models import xml_reading as xml
from sim_nodes.physics import BodyModel, Part
from sim_nodes.views import Colour

MODEL_ELEMENTS = frozenset({"static", "link", "pose", "self_collide", "allow_auto_disable"})
LINK_ELEMENTS = frozenset({"pose", "inertial", "collision", "visual", "self_collide"})
INERTIAL_ELEMENTS = frozenset({"mass", "inertia"})
COLLISION_ELEMENTS = frozenset({"pose", "geometry", "surface"})
SURFACE_ELEMENTS = {"surface": frozenset({"friction"}), "friction": frozenset({"ode"}), "ode": frozenset({"mu"})}


def read_sdf(root: Any, *, static: bool) -> BodyModel:
    """Read the body of an SDF file.

    Args:
        root: Root element.
        static: Whether the body is static regardless of the file.

    Raises:
        RequestRefused: The model is invalid or has unsupported parts.
    """
    if root.find("world") is not None:
        raise xml.invalid("unsupported <world> in the SDF file; expected one <model> directly under <sdf>")
    models = root.findall("model")
    if len(models) != 1:
        raise xml.invalid(f"found {len(models)} models directly under <sdf>; expected one")
    return _model(models[0], static=static)


def _model(model: Any, *, static: bool) -> BodyModel:
    xml.check_children(model, MODEL_ELEMENTS)
    links = model.findall("link")
    if len(links) != 1:
        raise xml.invalid(f"found {len(links)} links in <model>; expected one")
    link = links[0]
    xml.check_children(link, LINK_ELEMENTS)
    frame = xml.compose_frames(_pose(model), _pose(link))
    collisions = link.findall("collision")
    if not 1 <= len(collisions) <= xml.MAX_PARTS:
        raise xml.invalid(f"found {len(collisions)} <collision> elements in <link>; expected 1 to {xml.MAX_PARTS}")
    parts = tuple(_part(collision, frame) for collision in collisions)
    for inertial in link.findall("inertial"):
        xml.check_children(inertial, INERTIAL_ELEMENTS)
        for inertia in inertial.findall("inertia"):
            _check_inertia(inertia)
    frictions = {_friction(collision) for collision in collisions}
    if len(frictions) > 1:
        raise xml.invalid("unsupported: collisions of <link> with different friction; expected one value")
    return BodyModel(
        parts,
        mass=_number(link.find("inertial/mass"), xml.MASSES),
        friction=frictions.pop(),
        static=static or _boolean(model.find("static")),
        colour=_colour(link.find("visual/material/diffuse")),
    )


def _friction(collision: Any) -> float:
    """Return the coefficient of sliding friction, `surface/friction/ode/mu`."""
    xml.check_children(collision, COLLISION_ELEMENTS)
    element = collision.find("surface")
    while element is not None and element.tag != "mu":
        xml.check_children(element, SURFACE_ELEMENTS[element.tag])
        element = next(iter(element), None)
    return _number(element, xml.FRICTIONS)


def _colour(diffuse: Any) -> Colour | None:
    return None if diffuse is None else xml.read_colour(diffuse.text, "<diffuse>")


def _check_inertia(inertia: Any) -> None:
    """Check the inertia, although it is computed from mass and shapes here."""
    usual = {"ixx": "1", "iyy": "1", "izz": "1"}  # defaults of the SDF specification
    values = [inertia.findtext(name, usual.get(name, "0")) for name in xml.INERTIA]
    xml.check_inertia("<link>", xml.numbers(" ".join(values), "<inertia>", 6, xml.INERTIAS))


def _part(collision: Any, frame: xml.Frame) -> Part:
    position, orientation = xml.compose_frames(frame, _pose(collision))
    geometry, known = collision.find("geometry"), "<box>, <cylinder> or <sphere>"
    return Part(xml.read_shape("<collision>", geometry, _sizes, known), position, orientation)


def _sizes(shape: Any, name: str, count: int) -> list[float]:
    return _numbers(shape.find(name), name, count, xml.SIZES)


def _pose(element: Any) -> xml.Frame:
    pose = element.find("pose")
    if pose is None or not (pose.text or "").strip():
        return xml.ORIGIN
    if pose.get("relative_to"):
        raise xml.invalid(f"<pose relative_to={pose.get('relative_to')!r}> is unsupported; remove relative_to")
    if pose.get("rotation_format", "euler_rpy") != "euler_rpy":
        raise xml.invalid("unsupported format of <pose>; expected x y z roll pitch yaw")
    x, y, z, *angles = _numbers(pose, "pose", 6, xml.PLACES)
    scale = math.pi / 180.0 if pose.get("degrees") in ("true", "1") else 1.0
    roll, pitch, yaw = (angle * scale for angle in angles)
    return (x, y, z), quaternion(roll, pitch, yaw)


def _number(element: Any, bounds: tuple[float, float]) -> float:
    """Return the number in an element; 1 without one."""
    return 1.0 if element is None else _numbers(element, element.tag, 1, bounds)[0]


def _numbers(element: Any, name: str, count: int, bounds: tuple[float, float]) -> list[float]:
    return xml.numbers(None if element is None else element.text, f"<{name}>", count, bounds)


def _boolean(element: Any) -> bool:
    text = "false" if element is None else (element.text or "").strip()
    if text not in ("true", "false", "1", "0"):
        raise xml.invalid(f"invalid <{element.tag}>: {text!r}; expected true or false")
    return text in ("true", "1")
