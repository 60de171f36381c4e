"""Models in MJCF (https://mujoco.readthedocs.io/en/stable/XMLreference.html): rigid bodies of primitive shapes.

As in MuJoCo, a body with a free joint moves, and others are static. What not every engine can simulate is refused
by name: movable joints, actuators, meshes, capsules, contact parameters. The colour is that of the first geom that
has one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from sim_nodes.extents import volume
from sim_nodes.geometry import Quaternion, quaternion, quaternion_of, rotation_matrix
from sim_nodes.models import xml_reading as xml
from sim_nodes.physics import BodyModel, Box, Cylinder, Part, Shape, Sphere
from sim_nodes.views import Colour

ROOT_ELEMENTS = frozenset({"compiler", "default", "worldbody"})
BODY_ELEMENTS = frozenset({"body", "geom", "freejoint", "joint", "inertial"})
TURNS = frozenset({"quat", "euler", "axisangle", "zaxis"})
PLACE = frozenset({"name", "pos"}) | TURNS
GEOM = PLACE | {"type", "size", "fromto", "mass", "density", "friction", "rgba", "group"}
DENSITY = 1000.0  # [kg/m^3], MuJoCo's default
DENSITIES = (0.0, 1e6)
OTHER_FRICTIONS = (0.005, 0.0001)  # torsional and rolling, MuJoCo's defaults, which are fixed here
SHORTEST = 1e-6  # [m] minimum length of a direction


@dataclass(frozen=True)
class _Reader:
    """Settings of a file that affect all later elements."""

    degrees: bool = True  # the default of MJCF
    geom: Mapping[str, str] = field(default_factory=dict)  # default attributes of geoms


@dataclass(frozen=True)
class _Geom:
    part: Part
    friction: float
    colour: Colour | None


def read_mjcf(root: Any, *, static: bool) -> BodyModel:
    """Read the body of an MJCF file.

    Args:
        root: Root element.
        static: Whether the body is static even with a free joint.

    Raises:
        RequestRefused: The model is invalid or has unsupported parts.
    """
    xml.check_children(root, ROOT_ELEMENTS)
    reader = _Reader(_in_degrees(root), _defaults(root))
    world = root.findall("worldbody")
    if len(world) != 1:
        raise xml.invalid(f"found {len(world)} <worldbody> in the model; expected one")
    xml.check_children(world[0], frozenset({"body", "geom"}))
    free = [body for body in world[0].findall("body") if _is_free(body)]
    if free and len(world[0]) > 1:
        raise xml.invalid(
            f"{xml.label(free[0])} moves beside others in <worldbody>; "
            "expected one moving body, or only static ones"
        )
    geoms = [found for element in world[0] for found in _geoms(element, xml.ORIGIN, reader, xml.MAX_DEPTH)]
    frictions = {geom.friction for geom in geoms}
    if len(frictions) > 1:
        raise xml.invalid("unsupported: geoms with different friction; expected one value")
    parts = tuple(geom.part for geom in geoms)
    return xml.body_of(
        parts,
        static=static or not free,
        colour=next((geom.colour for geom in geoms if geom.colour is not None), None),
        friction=next(iter(frictions), 1.0),
    )


def _in_degrees(root: Any) -> bool:
    angle = "degree"
    for compiler in root.findall("compiler"):
        xml.check_attributes(compiler, {"angle", "autolimits"})
        angle = compiler.get("angle", angle)
    if angle not in ("degree", "radian"):
        raise xml.invalid(f"invalid angle {angle!r} of <compiler>; expected 'degree' or 'radian'")
    return angle == "degree"


def _defaults(root: Any) -> dict[str, str]:
    found: dict[str, str] = {}
    for default in root.findall("default"):
        xml.check_children(default, frozenset({"geom"}))
        for geom in default:
            xml.check_attributes(geom, GEOM - PLACE)
            found |= dict(geom.items())
    return found


def _is_free(body: Any) -> bool:
    return body.find("freejoint") is not None or any(
        joint.get("type") == "free" for joint in body.findall("joint")
    )


def _geoms(element: Any, outer: xml.Frame, reader: _Reader, depth: int) -> Iterator[_Geom]:
    """Yield a geom, or the geoms of a body and its descendants, in the frame of the model."""
    if element.tag == "geom":
        yield _geom(element, outer, reader)
        return
    if not depth:
        raise xml.invalid(f"bodies are nested more than {xml.MAX_DEPTH} deep")
    xml.check_attributes(element, PLACE)
    xml.check_children(element, BODY_ELEMENTS)
    _check_joints(element, is_outermost=depth == xml.MAX_DEPTH)
    # The initial pose of a moving body is set when it is spawned.
    frame = xml.ORIGIN if _is_free(element) else xml.compose_frames(outer, _frame(element, reader))
    own = [_geom(child, xml.ORIGIN, reader) for child in element.findall("geom")]
    yield from (replace(geom, part=xml.moved(geom.part, frame)) for geom in _weighed(element, own))
    for child in element.findall("body"):
        yield from _geoms(child, frame, reader, depth - 1)


def _check_joints(body: Any, *, is_outermost: bool) -> None:
    joints = [*body.findall("freejoint"), *body.findall("joint")]
    for joint in joints:
        kind = "free" if joint.tag == "freejoint" else joint.get("type", "hinge")
        if kind != "free" or not is_outermost:
            raise xml.invalid(
                f"{xml.label(body)} has a {kind} joint; expected at most a free joint of the outermost body"
            )
        xml.check_attributes(joint, {"name", "type"} if joint.tag == "joint" else {"name"})
    if len(joints) > 1:
        raise xml.invalid(f"{xml.label(body)} has {len(joints)} joints; expected at most one")


def _weighed(body: Any, geoms: list[_Geom]) -> list[_Geom]:
    """Distribute the mass of the body's <inertial> over its geoms, if there is one."""
    inertial = body.find("inertial")
    if inertial is None:
        return geoms
    if not geoms:
        raise xml.invalid(f"{xml.label(body)} has a mass but no geom")
    xml.check_attributes(inertial, {"pos", "mass", "diaginertia", "fullinertia"} | TURNS)
    (mass,) = xml.numbers(inertial.get("mass"), f"mass of {xml.label(body)}", 1, xml.MASSES)
    for name, count in (("diaginertia", 3), ("fullinertia", 6)):
        if inertial.get(name) is not None:
            found = xml.numbers(inertial.get(name), f"{name} of {xml.label(body)}", count, xml.INERTIAS)
            xml.check_inertia(xml.label(body), [*found, *[0.0] * (6 - count)])
    parts = xml.with_masses((geom.part for geom in geoms), mass)
    xml.check_centre(
        xml.label(body), xml.vector(inertial.get("pos"), f"pos of <inertial> in {xml.label(body)}"), parts
    )
    return [replace(geom, part=part) for part, geom in zip(parts, geoms, strict=True)]


def _geom(element: Any, outer: xml.Frame, reader: _Reader) -> _Geom:
    xml.check_attributes(element, GEOM)
    attributes = {**reader.geom, **dict(element.items())}
    shape, frame = _shape_and_frame(element, attributes, reader)
    position, orientation = xml.compose_frames(outer, frame)
    part = Part(shape, position, orientation, _mass(element, attributes, shape))
    colour = xml.read_colour(attributes["rgba"], f"rgba of {xml.label(element)}") if "rgba" in attributes else None
    return _Geom(part, _friction(element, attributes), colour)


def _shape_and_frame(element: Any, attributes: Mapping[str, str], reader: _Reader) -> tuple[Shape, xml.Frame]:
    kind, size, what = attributes.get("type", "sphere"), attributes.get("size"), f"size of {xml.label(element)}"
    if "fromto" in attributes:
        return _from_to(element, attributes)
    frame = _frame(element, reader)
    halves = (xml.SIZES[0] / 2, xml.SIZES[1] / 2)
    match kind:
        case "box":
            x, y, z = xml.vector(size, what, halves)
            return Box((2 * x, 2 * y, 2 * z)), frame
        case "cylinder":
            radius, half = xml.numbers(size, what, 2, halves)
            return Cylinder(radius, 2 * half), frame
        case "sphere":
            return Sphere(xml.numbers(size, what, 1, halves)[0]), frame
        case "mesh":
            raise xml.no_meshes()
        case _:
            raise xml.invalid(f"{xml.label(element)} has the unsupported type {kind!r}; expected {xml.SHAPES}")


def _from_to(element: Any, attributes: Mapping[str, str]) -> tuple[Shape, xml.Frame]:
    """Return a cylinder by the end points of its axis."""
    if attributes.get("type") != "cylinder":
        raise xml.invalid(f"{xml.label(element)} has `fromto`, which is supported for cylinders only")
    ends = np.array(
        xml.numbers(attributes["fromto"], f"fromto of {xml.label(element)}", 6, (-1000.0, 1000.0))
    ).reshape(2, 3)
    (radius,) = xml.numbers(attributes.get("size"), f"size of {xml.label(element)}", 1, xml.SIZES)
    length = float(np.linalg.norm(ends[1] - ends[0]))
    if not xml.SIZES[0] <= length <= xml.SIZES[1]:
        raise xml.invalid(
            f"{xml.label(element)} is {length:g} m long; expected {xml.SIZES[0]:g} to {xml.SIZES[1]:g} m"
        )
    x, y, z = ends.mean(axis=0).tolist()
    return Cylinder(radius, length), ((x, y, z), _towards(ends[1] - ends[0], f"fromto of {xml.label(element)}"))


def _frame(element: Any, reader: _Reader) -> xml.Frame:
    turns = sorted(TURNS & set(element.keys()))
    if len(turns) > 1:
        raise xml.invalid(f"{xml.label(element)} has both {turns[0]!r} and {turns[1]!r}; expected one orientation")
    position = xml.vector(element.get("pos", "0 0 0"), f"pos of {xml.label(element)}")
    return position, _orientation(element, turns[0], reader) if turns else xml.ORIGIN[1]


def _orientation(element: Any, kind: str, reader: _Reader) -> Quaternion:
    text, what = element.get(kind), f"{kind} of {xml.label(element)}"
    scale = math.pi / 180.0 if reader.degrees else 1.0
    match kind:
        case "quat":
            w, x, y, z = xml.numbers(text, what, 4, (-1e6, 1e6))
            return _unit((w, x, y, z), what)
        case "euler":
            x, y, z = (angle * scale for angle in xml.vector(text, what))
            # MJCF rotates about x, then the new y, then the new z.
            turned = [rotation_matrix(quaternion(*angles)) for angles in ((x, 0, 0), (0, y, 0), (0, 0, z))]
            return quaternion_of(turned[0] @ turned[1] @ turned[2])
        case "axisangle":
            x, y, z, angle = xml.numbers(text, what, 4, (-1000.0, 1000.0))
            half = angle * scale / 2
            _, i, j, k = _unit((0.0, x, y, z), what)
            return math.cos(half), i * math.sin(half), j * math.sin(half), k * math.sin(half)
        case _:
            return _towards(np.array(xml.vector(text, what)), what)


def _unit(values: Quaternion, what: str) -> Quaternion:
    norm = math.hypot(*values)
    if norm < SHORTEST:
        raise xml.invalid(f"zero length: {what}")
    w, x, y, z = (value / norm for value in values)
    return w, x, y, z


def _towards(axis: Any, what: str) -> Quaternion:
    """Return the smallest rotation from z to an axis."""
    x, y, z = axis.tolist()
    norm = math.hypot(x, y, z)
    if norm < SHORTEST:
        raise xml.invalid(f"zero length: {what}")
    if z < 0 and math.hypot(x, y) < SHORTEST * norm:
        return 0.0, 1.0, 0.0, 0.0
    return _unit((norm + z, -y, x, 0.0), what)


def _mass(element: Any, attributes: Mapping[str, str], shape: Shape) -> float:
    if "mass" in attributes:
        return xml.numbers(attributes["mass"], f"mass of {xml.label(element)}", 1, (0.0, xml.MASSES[1]))[0]
    (density,) = xml.numbers(
        attributes.get("density", str(DENSITY)), f"density of {xml.label(element)}", 1, DENSITIES
    )
    return density * volume(shape)


def _friction(element: Any, attributes: Mapping[str, str]) -> float:
    text, what = attributes.get("friction", "1"), f"friction of {xml.label(element)}"
    sliding, *others = xml.numbers(text, what, len(text.split()), xml.FRICTIONS)
    if tuple(others) != OTHER_FRICTIONS[: len(others)]:
        raise xml.invalid(f"unsupported {what} {text!r}; only the first value, sliding friction, can be changed")
    return sliding
