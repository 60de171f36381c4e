"""Models in MJCF (https://mujoco.readthedocs.io/en/stable/XMLreference.html): rigid bodies of primitive shapes.

As in MuJoCo, a body with a free joint moves, and what has none stands fixed. What not every engine can simulate is
refused by name: joints that move, actuators, meshes, capsules, what changes how surfaces touch. Pictures show the
model in the colour of its first geom that has one.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from sim_nodes.colours import Colour
from sim_nodes.geometry import Quaternion, quaternion, quaternion_of, rotation_matrix
from sim_nodes.inertia import volume
from sim_nodes.models.reading import (
    FRICTIONS,
    INERTIAS,
    MASSES,
    MAX_DEPTH,
    ORIGIN,
    SIZES,
    Frame,
    body_of,
    check_attributes,
    check_centre,
    check_children,
    check_inertia,
    inside,
    named,
    no_meshes,
    numbers,
    read_colour,
    symmetric,
    vector,
    weighed,
    wrong,
)
from sim_nodes.physics import BodyModel, Box, Cylinder, Part, Shape, Sphere

ROOT_ELEMENTS = frozenset({"compiler", "default", "worldbody"})
BODY_ELEMENTS = frozenset({"body", "geom", "freejoint", "joint", "inertial"})
TURNS = frozenset({"quat", "euler", "axisangle", "zaxis"})
PLACE = frozenset({"name", "pos"}) | TURNS
GEOM = PLACE | {"type", "size", "fromto", "mass", "density", "friction", "rgba", "group"}
SHAPES = "box, cylinder or sphere"
DENSITY = 1000.0  # [kg/m^3], MuJoCo's default
DENSITIES = (0.0, 1e6)
OTHER_FRICTIONS = (0.005, 0.0001)  # torsional and rolling, MuJoCo's defaults, which are not for change here
SHORTEST = 1e-6  # [m], of what says a direction


@dataclass(frozen=True)
class _Reader:
    """What the head of a file says of all that follows."""

    degrees: bool = True  # the default of MJCF
    geom: Mapping[str, str] = field(default_factory=dict)  # attributes of geoms that do not say otherwise


@dataclass(frozen=True)
class _Geom:
    part: Part
    friction: float
    colour: Colour | None


def read_mjcf(root: Any, *, static: bool) -> BodyModel:
    """The body that an MJCF file describes.

    Args:
        root: Its root element.
        static: Whether it is to stand fixed, also if it has a free joint.

    Raises:
        RequestRefused: It has something that is not supported.
    """
    check_children(root, ROOT_ELEMENTS)
    reader = _Reader(_in_degrees(root), _defaults(root))
    world = root.findall("worldbody")
    if len(world) != 1:
        raise wrong(f"the model has {len(world)} <worldbody>: it has to have one")
    check_children(world[0], frozenset({"body", "geom"}))
    free = [body for body in world[0].findall("body") if _is_free(body)]
    if free and len(world[0]) > 1:
        raise wrong(
            f"{named(free[0])} moves, and is not alone in <worldbody>: a model is one body, or all of it fixed"
        )
    geoms = [found for element in world[0] for found in _geoms(element, ORIGIN, reader, MAX_DEPTH)]
    frictions = {geom.friction for geom in geoms}
    if len(frictions) > 1:
        raise wrong("the geoms have different friction: give all the same")
    parts = tuple(geom.part for geom in geoms)
    return body_of(
        parts,
        static=static or not free,
        colour=next((geom.colour for geom in geoms if geom.colour is not None), None),
        friction=next(iter(frictions), 1.0),
    )


def _in_degrees(root: Any) -> bool:
    angle = "degree"
    for compiler in root.findall("compiler"):
        check_attributes(compiler, {"angle", "autolimits"})
        angle = compiler.get("angle", angle)
    if angle not in ("degree", "radian"):
        raise wrong(f"the angle of <compiler> is {angle!r}: it has to be 'degree' or 'radian'")
    return angle == "degree"


def _defaults(root: Any) -> dict[str, str]:
    found: dict[str, str] = {}
    for default in root.findall("default"):
        check_children(default, frozenset({"geom"}))
        for geom in default:
            check_attributes(geom, GEOM - PLACE)
            found |= dict(geom.items())
    return found


def _is_free(body: Any) -> bool:
    return body.find("freejoint") is not None or any(
        joint.get("type") == "free" for joint in body.findall("joint")
    )


def _geoms(element: Any, outer: Frame, reader: _Reader, depth: int) -> Iterator[_Geom]:
    """The geoms of a body with all that hangs on it, or of a geom alone, in the frame of the model."""
    if element.tag == "geom":
        yield _geom(element, outer, reader)
        return
    if not depth:
        raise wrong(f"bodies are more than {MAX_DEPTH} deep within each other")
    check_attributes(element, PLACE)
    check_children(element, BODY_ELEMENTS)
    _check_joints(element, is_outermost=depth == MAX_DEPTH)
    # What moves is placed where it is spawned, whatever its file says.
    frame = ORIGIN if _is_free(element) else inside(outer, _frame(element, reader))
    own = [_geom(child, ORIGIN, reader) for child in element.findall("geom")]
    yield from (replace(geom, part=_moved(geom.part, frame)) for geom in _weighed(element, own))
    for child in element.findall("body"):
        yield from _geoms(child, frame, reader, depth - 1)


def _check_joints(body: Any, *, is_outermost: bool) -> None:
    joints = [*body.findall("freejoint"), *body.findall("joint")]
    for joint in joints:
        kind = "free" if joint.tag == "freejoint" else joint.get("type", "hinge")
        if kind != "free" or not is_outermost:
            raise wrong(
                f"{named(body)} has a {kind} joint: bodies are rigid here, and only the outermost has a free joint"
            )
        check_attributes(joint, {"name", "type"} if joint.tag == "joint" else {"name"})
    if len(joints) > 1:
        raise wrong(f"{named(body)} has {len(joints)} joints: one is enough")


def _weighed(body: Any, geoms: list[_Geom]) -> list[_Geom]:
    """Geoms with the mass that the body's <inertial> says, if there is one."""
    inertial = body.find("inertial")
    if inertial is None:
        return geoms
    if not geoms:
        raise wrong(f"{named(body)} has a mass, but no geom whose shape it could fill")
    check_attributes(inertial, {"pos", "mass", "diaginertia", "fullinertia"} | TURNS)
    (mass,) = numbers(inertial.get("mass"), f"mass of {named(body)}", 1, MASSES)
    for name, count in (("diaginertia", 3), ("fullinertia", 6)):
        if inertial.get(name) is not None:
            found = numbers(inertial.get(name), f"{name} of {named(body)}", count, INERTIAS)
            check_inertia(named(body), symmetric([*found, *[0.0] * (6 - count)]))
    parts = weighed((geom.part for geom in geoms), mass)
    check_centre(named(body), vector(inertial.get("pos"), f"pos of <inertial> in {named(body)}"), parts)
    return [replace(geom, part=part) for part, geom in zip(parts, geoms, strict=True)]


def _geom(element: Any, outer: Frame, reader: _Reader) -> _Geom:
    check_attributes(element, GEOM)
    says = {**reader.geom, **dict(element.items())}
    shape, frame = _shape_and_frame(element, says, reader)
    position, orientation = inside(outer, frame)
    part = Part(shape, position, orientation, _mass(element, says, shape))
    colour = read_colour(says["rgba"], f"rgba of {named(element)}") if "rgba" in says else None
    return _Geom(part, _friction(element, says), colour)


def _shape_and_frame(element: Any, says: Mapping[str, str], reader: _Reader) -> tuple[Shape, Frame]:
    kind, size, what = says.get("type", "sphere"), says.get("size"), f"size of {named(element)}"
    if "fromto" in says:
        return _from_to(element, says)
    frame = _frame(element, reader)
    halves = (SIZES[0] / 2, SIZES[1] / 2)
    match kind:
        case "box":
            x, y, z = vector(size, what, halves)
            return Box((2 * x, 2 * y, 2 * z)), frame
        case "cylinder":
            radius, half = numbers(size, what, 2, halves)
            return Cylinder(radius, 2 * half), frame
        case "sphere":
            return Sphere(numbers(size, what, 1, halves)[0]), frame
        case "mesh":
            raise no_meshes(SHAPES)
        case _:
            raise wrong(f"{named(element)} is of type {kind!r}, which is not supported: use {SHAPES}")


def _from_to(element: Any, says: Mapping[str, str]) -> tuple[Shape, Frame]:
    """A cylinder by the ends of its axis."""
    if says.get("type") != "cylinder":
        raise wrong(f"{named(element)} has `fromto`, which is supported for cylinders")
    ends = np.array(numbers(says["fromto"], f"fromto of {named(element)}", 6, (-1000.0, 1000.0))).reshape(2, 3)
    (radius,) = numbers(says.get("size"), f"size of {named(element)}", 1, SIZES)
    length = float(np.linalg.norm(ends[1] - ends[0]))
    if not SIZES[0] <= length <= SIZES[1]:
        raise wrong(f"{named(element)} is {length:g} m long: {SIZES[0]:g} to {SIZES[1]:g} m are supported")
    x, y, z = ends.mean(axis=0).tolist()
    return Cylinder(radius, length), ((x, y, z), _towards(ends[1] - ends[0], f"fromto of {named(element)}"))


def _frame(element: Any, reader: _Reader) -> Frame:
    turns = sorted(TURNS & set(element.keys()))
    if len(turns) > 1:
        raise wrong(f"{named(element)} has both {turns[0]!r} and {turns[1]!r}: one orientation is enough")
    position = vector(element.get("pos", "0 0 0"), f"pos of {named(element)}")
    return position, _orientation(element, turns[0], reader) if turns else ORIGIN[1]


def _orientation(element: Any, kind: str, reader: _Reader) -> Quaternion:
    text, what = element.get(kind), f"{kind} of {named(element)}"
    scale = math.pi / 180.0 if reader.degrees else 1.0
    match kind:
        case "quat":
            w, x, y, z = numbers(text, what, 4, (-1e6, 1e6))
            return _unit((w, x, y, z), what)
        case "euler":
            x, y, z = (angle * scale for angle in vector(text, what))
            # MJCF turns about x, then the new y, then the new z.
            turned = [rotation_matrix(quaternion(*angles)) for angles in ((x, 0, 0), (0, y, 0), (0, 0, z))]
            return quaternion_of(turned[0] @ turned[1] @ turned[2])
        case "axisangle":
            x, y, z, angle = numbers(text, what, 4, (-1000.0, 1000.0))
            half = angle * scale / 2
            _, i, j, k = _unit((0.0, x, y, z), what)
            return math.cos(half), i * math.sin(half), j * math.sin(half), k * math.sin(half)
        case _:
            return _towards(np.array(vector(text, what)), what)


def _unit(values: Quaternion, what: str) -> Quaternion:
    norm = math.hypot(*values)
    if norm < SHORTEST:
        raise wrong(f"{what} has no length")
    w, x, y, z = (value / norm for value in values)
    return w, x, y, z


def _towards(axis: Any, what: str) -> Quaternion:
    """The least turn that takes z to an axis."""
    x, y, z = axis.tolist()
    norm = math.hypot(x, y, z)
    if norm < SHORTEST:
        raise wrong(f"{what} has no length")
    if z < 0 and math.hypot(x, y) < SHORTEST * norm:
        return 0.0, 1.0, 0.0, 0.0
    return _unit((norm + z, -y, x, 0.0), what)


def _mass(element: Any, says: Mapping[str, str], shape: Shape) -> float:
    if "mass" in says:
        return numbers(says["mass"], f"mass of {named(element)}", 1, (0.0, MASSES[1]))[0]
    (density,) = numbers(says.get("density", str(DENSITY)), f"density of {named(element)}", 1, DENSITIES)
    return density * volume(shape)


def _friction(element: Any, says: Mapping[str, str]) -> float:
    text, what = says.get("friction", "1"), f"friction of {named(element)}"
    sliding, *others = numbers(text, what, len(text.split()), FRICTIONS)
    if tuple(others) != OTHER_FRICTIONS[: len(others)]:
        raise wrong(f"{what} is {text!r}: only sliding friction, the first of the three, can be chosen")
    return sliding


def _moved(part: Part, frame: Frame) -> Part:
    position, orientation = inside(frame, (part.position, part.orientation))
    return Part(part.shape, position, orientation, part.mass)
