"""Models in URDF (http://wiki.ros.org/urdf/XML): rigid bodies, of one link or of links at fixed joints.

What cannot be simulated in every engine is refused by name: joints that move, meshes, extensions for simulators.
Pictures show what collides, opaque, in the colour of the first visual that has one; what else visuals have is
allowed without effect, and so are matrices of inertia, which follow from mass and shapes here.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from sim_nodes.colours import Colour
from sim_nodes.geometry import quaternion
from sim_nodes.models.reading import (
    INERTIAS,
    MASSES,
    MAX_DEPTH,
    ORIGIN,
    SIZES,
    Frame,
    body_of,
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

ROBOT_ELEMENTS = frozenset({"link", "joint", "material"})
LINK_ELEMENTS = frozenset({"inertial", "visual", "collision"})
SHAPES = "box, cylinder or sphere"


def read_urdf(root: Any, *, static: bool) -> BodyModel:
    """The body that a URDF file describes.

    Args:
        root: Its root element.
        static: Whether it is to stand fixed; then it needs no masses.

    Raises:
        RequestRefused: It has something that is not supported.
    """
    check_children(root, ROBOT_ELEMENTS)
    links = {link.get("name"): link for link in root.findall("link")}
    if len(links) != len(root.findall("link")) or None in links:
        raise wrong("each <link> has to have a name of its own")
    parts: list[Part] = []
    for name, frame in _frames(root, links):
        parts += _parts(links[name], frame, static=static)
    return body_of(tuple(parts), static=static, colour=_colour(root))


def _frames(root: Any, links: dict[str, Any]) -> Iterator[tuple[str, Frame]]:
    """Each link with its frame in that of the link that everything hangs on."""
    hung: dict[str, tuple[str, Frame]] = {}
    for joint in root.findall("joint"):
        kind = joint.get("type")
        if kind != "fixed":
            raise wrong(f"{named(joint)} is of type {kind!r}: bodies are rigid here, joints have to be 'fixed'")
        parent, child = (_link_of(joint, tag, links) for tag in ("parent", "child"))
        if child in hung:
            raise wrong(f"the link {child!r} is the child of two joints")
        hung[child] = (parent, read_origin(joint))
    roots = [name for name in links if name not in hung]
    if len(roots) != 1:
        raise wrong(f"the model has {len(roots)} links that hang on no other: it has to have one")
    for name in links:
        frame, link = ORIGIN, name
        for _ in range(MAX_DEPTH):
            if link not in hung:
                break
            link, origin = hung[link]
            frame = inside(origin, frame)
        else:
            raise wrong(f"the link {name!r} hangs on itself, or on more than {MAX_DEPTH} others")
        yield name, frame


def _link_of(joint: Any, tag: str, links: dict[str, Any]) -> str:
    element = joint.find(tag)
    name = None if element is None else element.get("link")
    if name not in links:
        raise wrong(f"{named(joint)}: there is no link {name!r} to be its {tag}")
    return str(name)


def _colour(root: Any) -> Colour | None:
    """The colour of the first visual that has one, of its own or by the name of a material."""
    known = {material.get("name"): material for material in root.findall("material")}
    for material in root.findall("link/visual/material"):
        colour = material.find("color")
        if colour is None and material.get("name") in known:
            colour = known[material.get("name")].find("color")
        if colour is not None:
            return read_colour(colour.get("rgba"), "rgba of <color>")
    return None


def read_origin(element: Any) -> Frame:
    """The frame that an element's <origin> says, or that of what it belongs to."""
    origin = element.find("origin")
    if origin is None:
        return ORIGIN
    roll, pitch, yaw = vector(origin.get("rpy", "0 0 0"), f"rpy of {named(element)}")
    return vector(origin.get("xyz", "0 0 0"), f"xyz of {named(element)}"), quaternion(roll, pitch, yaw)


def _parts(link: Any, frame: Frame, *, static: bool) -> tuple[Part, ...]:
    check_children(link, LINK_ELEMENTS)
    own = [_part(collision) for collision in link.findall("collision")]
    inertial = link.find("inertial")
    _check_inertia(link)
    if own and not static:
        if inertial is None:
            raise wrong(f"{named(link)} collides, but has no <inertial> with a <mass>")
        own = list(weighed(own, _mass(link, inertial)))
        check_centre(named(link), read_origin(inertial)[0], own)
    elif inertial is not None and not own:
        raise wrong(f"{named(link)} has a mass, but no <collision> whose shape it could fill")
    return tuple(_moved(part, frame) for part in own)


def _check_inertia(link: Any) -> None:
    """Refuse what no body has, although inertia follows from mass and shapes here."""
    for inertia in link.findall("inertial/inertia"):
        values = [inertia.get(name, "0") for name in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")]
        found = numbers(" ".join(values), f"inertia of {named(link)}", 6, INERTIAS)
        check_inertia(named(link), symmetric(found))


def _mass(link: Any, inertial: Any) -> float:
    mass = inertial.find("mass")
    return numbers(None if mass is None else mass.get("value"), f"mass of {named(link)}", 1, MASSES)[0]


def _part(collision: Any) -> Part:
    position, orientation = read_origin(collision)
    return Part(read_shape(collision), position, orientation)


def _moved(part: Part, frame: Frame) -> Part:
    position, orientation = inside(frame, (part.position, part.orientation))
    return Part(part.shape, position, orientation, part.mass)


def read_shape(element: Any, sizes: tuple[float, float] = SIZES) -> Shape:
    """The shape of a <collision> or <visual>, whose edges, radii and lengths are within some sizes [m].

    Raises:
        RequestRefused: It has none, or one that is not supported.
    """
    geometry = element.find("geometry")
    children = [] if geometry is None else list(geometry)
    if len(children) != 1:
        raise wrong(f"{named(element)} has to have a <geometry> with one shape in it")
    shape = children[0]
    match shape.tag:
        case "box":
            return Box(vector(shape.get("size"), "size of <box>", sizes))
        case "cylinder":
            return Cylinder(_length(shape, "radius", sizes), _length(shape, "length", sizes))
        case "sphere":
            return Sphere(_length(shape, "radius", sizes))
        case "mesh":
            raise no_meshes(SHAPES)
        case other:
            raise wrong(f"<geometry> contains <{other}>, which is not supported: use {SHAPES}")


def _length(shape: Any, name: str, sizes: tuple[float, float]) -> float:
    return numbers(shape.get(name), f"{name} of <{shape.tag}>", 1, sizes)[0]
