"""Models in URDF (http://wiki.ros.org/urdf/XML): rigid bodies of one link, or of links with fixed joints.

Parts that some engine cannot simulate are refused by name: movable joints, meshes, extensions. Images
show the collision shapes, opaque, in the colour of the first visual that has one. Accepted without effect are
other parts of visuals, and inertia matrices, which follow from mass and shapes here.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from sim_nodes.geometry import quaternion
from sim_nodes.models import xml_reading as xml
from sim_nodes.physics import BodyModel, Part, Shape
from sim_nodes.views import Colour

ROBOT_ELEMENTS = frozenset({"link", "joint", "material"})
LINK_ELEMENTS = frozenset({"inertial", "visual", "collision"})


def read_urdf(root: Any, *, static: bool) -> BodyModel:
    """Read the body of a URDF file.

    Args:
        root: Root element.
        static: Whether the body is static; then it needs no masses.

    Raises:
        RequestRefused: The model is invalid or has unsupported parts.
    """
    xml.check_children(root, ROBOT_ELEMENTS)
    links = {link.get("name"): link for link in root.findall("link")}
    if len(links) != len(root.findall("link")) or None in links:
        raise xml.invalid("missing or duplicate name of a <link>")
    parts: list[Part] = []
    for name, frame in _frames(root, links):
        parts += _parts(links[name], frame, static=static)
    return xml.body_of(tuple(parts), static=static, colour=_colour(root))


def _frames(root: Any, links: dict[str, Any]) -> Iterator[tuple[str, xml.Frame]]:
    """Yield each link with its frame in that of the root link."""
    hung: dict[str, tuple[str, xml.Frame]] = {}
    for joint in root.findall("joint"):
        kind = joint.get("type")
        if kind != "fixed":
            raise xml.invalid(f"{xml.label(joint)} has the unsupported type {kind!r}; expected 'fixed'")
        parent, child = (link_of(joint, tag, links) for tag in ("parent", "child"))
        if child in hung:
            raise xml.invalid(f"link {child!r} is the child of two joints")
        hung[child] = (parent, read_origin(joint))
    roots = [name for name in links if name not in hung]
    if len(roots) != 1:
        raise xml.invalid(f"found {len(roots)} root links in the model; expected one")
    for name in links:
        yield name, frame_of(name, hung)


def frame_of(link: str, hung: Mapping[str, tuple[str, xml.Frame]]) -> xml.Frame:
    """Return the frame of a link in that of its root, with all joints at zero.

    Args:
        link: Name of the link.
        hung: Parent link and frame of each joint, by child link.
    """
    frame, ancestor = xml.ORIGIN, link
    for _ in range(xml.MAX_DEPTH):
        if ancestor not in hung:
            return frame
        ancestor, origin = hung[ancestor]
        frame = xml.compose_frames(origin, frame)
    raise xml.invalid(f"link {link!r} is its own ancestor, or has more than {xml.MAX_DEPTH} ancestors")


def link_of(joint: Any, tag: str, links: Mapping[str, Any]) -> str:
    """Return the name of the `parent` or `child` link of a joint, which must be known."""
    element = joint.find(tag)
    name = None if element is None else element.get("link")
    if name not in links:
        raise xml.invalid(f"{xml.label(joint)}: unknown {tag} link {name!r}")
    return str(name)


def _colour(root: Any) -> Colour | None:
    """Return the colour of the first visual that has one, directly or by the name of a material."""
    known = {material.get("name"): material for material in root.findall("material")}
    for material in root.findall("link/visual/material"):
        colour = material.find("color")
        if colour is None and material.get("name") in known:
            colour = known[material.get("name")].find("color")
        if colour is not None:
            return xml.read_colour(colour.get("rgba"), "rgba of <color>")
    return None


def read_origin(element: Any) -> xml.Frame:
    """Return the frame of an element's <origin>, or the identity."""
    origin = element.find("origin")
    if origin is None:
        return xml.ORIGIN
    roll, pitch, yaw = xml.vector(origin.get("rpy", "0 0 0"), f"rpy of {xml.label(element)}")
    return xml.vector(origin.get("xyz", "0 0 0"), f"xyz of {xml.label(element)}"), quaternion(roll, pitch, yaw)


def _parts(link: Any, frame: xml.Frame, *, static: bool) -> tuple[Part, ...]:
    xml.check_children(link, LINK_ELEMENTS)
    own = [_part(collision) for collision in link.findall("collision")]
    inertial = link.find("inertial")
    _check_inertia(link)
    if own and not static:
        if inertial is None:
            raise xml.invalid(f"{xml.label(link)} has a <collision>, but no <inertial> with a <mass>")
        own = list(xml.with_masses(own, _mass(link, inertial)))
        xml.check_centre(xml.label(link), read_origin(inertial)[0], own)
    elif inertial is not None and not own:
        raise xml.invalid(f"{xml.label(link)} has a mass, but no <collision>")
    return tuple(xml.moved(part, frame) for part in own)


def _check_inertia(link: Any) -> None:
    """Check the inertia, although it is computed from mass and shapes here."""
    for inertia in link.findall("inertial/inertia"):
        values = [inertia.get(name, "0") for name in xml.INERTIA]
        found = xml.numbers(" ".join(values), f"inertia of {xml.label(link)}", 6, xml.INERTIAS)
        xml.check_inertia(xml.label(link), found)


def _mass(link: Any, inertial: Any) -> float:
    mass = inertial.find("mass")
    return xml.numbers(None if mass is None else mass.get("value"), f"mass of {xml.label(link)}", 1, xml.MASSES)[0]


def _part(collision: Any) -> Part:
    position, orientation = read_origin(collision)
    return Part(read_shape(collision), position, orientation)


def read_shape(element: Any, sizes: tuple[float, float] = xml.SIZES) -> Shape:
    """Read the shape of a <collision> or <visual>; edges, radii and lengths are within `sizes` [m].

    Raises:
        RequestRefused: The shape is missing or unsupported.
    """

    def read(shape: Any, name: str, count: int) -> list[float]:
        return xml.numbers(shape.get(name), f"{name} of <{shape.tag}>", count, sizes)

    return xml.read_shape(xml.label(element), element.find("geometry"), read, xml.SHAPES)
