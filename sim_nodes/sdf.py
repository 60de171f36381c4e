"""Models in SDF (http://sdformat.org): one link made of boxes, cylinders and spheres.

What cannot be simulated here is refused by name rather than left out: joints, nested models, plugins, sensors,
meshes, friction that differs by direction or shape. Pictures show the
collision shapes, opaque, in the diffuse colour of the first visual that has one; what else visuals have is allowed
without effect, as are the matrix of inertia, which follows from mass and shapes here, and switches that mean
nothing for a single link.
"""

from __future__ import annotations

import math
from typing import Any

from defusedxml import DefusedXmlException, ElementTree

from seoro.bridges.wire import SpawnResult
from sim_nodes.colours import Colour
from sim_nodes.geometry import Quaternion, Vector, multiply, quaternion, rotation_matrix
from sim_nodes.physics import IDENTITY, BodyModel, Box, Cylinder, Part, Shape, Sphere
from sim_nodes.refusal import RequestRefused

MAX_TEXT = 1_000_000  # [characters]
MAX_PARTS = 64
SIZES = (0.01, 20.0)  # [m] of an edge, radius or length
MASSES = (1e-3, 1e4)  # [kg]

MODEL_ELEMENTS = frozenset({"static", "link", "pose", "self_collide", "allow_auto_disable"})
LINK_ELEMENTS = frozenset({"pose", "inertial", "collision", "visual", "self_collide"})
INERTIAL_ELEMENTS = frozenset({"mass", "inertia"})
COLLISION_ELEMENTS = frozenset({"pose", "geometry", "surface"})
SURFACE_ELEMENTS = {"surface": frozenset({"friction"}), "friction": frozenset({"ode"}), "ode": frozenset({"mu"})}

Frame = tuple[Vector, Quaternion]


def parse_model(text: str) -> BodyModel:
    """The body that the text of an SDF file describes.

    Raises:
        RequestRefused: The text is no SDF, or has something in it that is not supported.
    """
    if len(text) > MAX_TEXT:
        raise _wrong(f"the model is longer than {MAX_TEXT} characters")
    try:
        root = ElementTree.fromstring(text)
    except (ElementTree.ParseError, DefusedXmlException, ValueError) as error:
        raise _wrong(f"the model is no well-formed XML: {error}") from error
    if root.tag != "sdf":
        raise RequestRefused(
            SpawnResult.UNSUPPORTED_FORMAT,
            f"the model's root element is <{root.tag}>: it has to be an SDF file, <sdf>",
        )
    models = root.findall("model")
    if len(models) != 1:
        raise _wrong(f"the SDF file has {len(models)} models directly under <sdf>: it has to have one")
    return _model(models[0])


def _wrong(message: str) -> RequestRefused:
    return RequestRefused(SpawnResult.RESOURCE_PARSE_ERROR, message)


def _model(model: Any) -> BodyModel:
    _only(model, MODEL_ELEMENTS)
    links = model.findall("link")
    if len(links) != 1:
        raise _wrong(f"<model> has {len(links)} links: models of one link are supported")
    link = links[0]
    _only(link, LINK_ELEMENTS)
    frame = _inside(_pose(model), _pose(link))
    collisions = link.findall("collision")
    if not 1 <= len(collisions) <= MAX_PARTS:
        raise _wrong(f"<link> has {len(collisions)} <collision> elements: it has to have 1 to {MAX_PARTS}")
    parts = tuple(_part(collision, frame) for collision in collisions)
    for inertial in link.findall("inertial"):
        _only(inertial, INERTIAL_ELEMENTS)
    frictions = {_friction(collision) for collision in collisions}
    if len(frictions) > 1:
        raise _wrong("the collisions of <link> have different friction: give all the same")
    return BodyModel(
        parts,
        mass=_number(link.find("inertial/mass"), MASSES, 1.0),
        friction=frictions.pop(),
        static=_truth(model.find("static")),
        colour=_colour(link.find("visual/material/diffuse")),
    )


def _only(element: Any, known: frozenset[str]) -> None:
    unknown = sorted({child.tag for child in element} - known)
    if unknown:
        raise _wrong(
            f"<{element.tag}> contains <{unknown[0]}>, which is not supported: it may contain {_tags(known)}"
        )


def _tags(names: frozenset[str]) -> str:
    return ", ".join(f"<{name}>" for name in sorted(names))


def _friction(collision: Any) -> float:
    """The coefficient of sliding friction, `surface/friction/ode/mu`."""
    _only(collision, COLLISION_ELEMENTS)
    element = collision.find("surface")
    while element is not None and element.tag != "mu":
        _only(element, SURFACE_ELEMENTS[element.tag])
        element = next(iter(element), None)
    return _number(element, (0.0, 10.0), 1.0)


def _colour(diffuse: Any) -> Colour | None:
    """Red, green and blue, and, if it is there, opacity, which is not used."""
    if diffuse is None:
        return None
    count = 3 if len((diffuse.text or "").split()) == 3 else 4
    red, green, blue, *_ = _numbers(diffuse, "diffuse", count, (0.0, 1.0))
    return red, green, blue, 1.0


def _part(collision: Any, frame: Frame) -> Part:
    position, orientation = _inside(frame, _pose(collision))
    return Part(_shape(collision.find("geometry")), position, orientation)


def _shape(geometry: Any) -> Shape:
    children = [] if geometry is None else list(geometry)
    if len(children) != 1:
        raise _wrong("<collision> has to have a <geometry> with one shape in it")
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
            raise RequestRefused(
                SpawnResult.UNSUPPORTED_ASSETS, "meshes are not supported: use box, cylinder or sphere"
            )
        case other:
            raise _wrong(f"<geometry> contains <{other}>: it may contain <box>, <cylinder> or <sphere>")


def _required(shape: Any, name: str) -> float:
    return _numbers(shape.find(name), name, 1, SIZES)[0]


def _pose(element: Any) -> Frame:
    pose = element.find("pose")
    if pose is None or not (pose.text or "").strip():
        return (0.0, 0.0, 0.0), IDENTITY
    if pose.get("relative_to"):
        raise _wrong(f"<pose relative_to={pose.get('relative_to')!r}> is not supported: leave relative_to out")
    if pose.get("rotation_format", "euler_rpy") != "euler_rpy":
        raise _wrong("<pose> is supported as x y z roll pitch yaw only")
    x, y, z, *angles = _numbers(pose, "pose", 6, (-1000.0, 1000.0))
    scale = math.pi / 180.0 if pose.get("degrees") in ("true", "1") else 1.0
    roll, pitch, yaw = (angle * scale for angle in angles)
    return (x, y, z), quaternion(roll, pitch, yaw)


def _inside(outer: Frame, inner: Frame) -> Frame:
    x, y, z = (rotation_matrix(outer[1]) @ inner[0] + outer[0]).tolist()
    return (x, y, z), multiply(outer[1], inner[1])


def _number(element: Any, bounds: tuple[float, float], default: float | None = None) -> float:
    if element is None and default is not None:
        return default
    return _numbers(element, "value" if element is None else element.tag, 1, bounds)[0]


def _numbers(element: Any, name: str, count: int, bounds: tuple[float, float]) -> list[float]:
    text = "" if element is None else element.text or ""
    try:
        values = [float(word) for word in text.split()]
    except ValueError as error:
        raise _wrong(f"<{name}> is {text.strip()!r}: it has to be {count} numbers") from error
    if len(values) != count:
        raise _wrong(f"<{name}> is {text.strip()!r}: it has to be {count} numbers")
    low, high = bounds
    if not all(low <= value <= high for value in values):
        raise _wrong(f"<{name}> is {text.strip()!r}: values are supported from {low:g} to {high:g}")
    return values


def _truth(element: Any) -> bool:
    text = "false" if element is None else (element.text or "").strip()
    if text not in ("true", "false", "1", "0"):
        raise _wrong(f"<{element.tag}> is {text!r}: it has to be true or false")
    return text in ("true", "1")
