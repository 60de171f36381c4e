"""Elements of URDF (http://wiki.ros.org/urdf/XML): read and written by all that load or translate models."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any, assert_never
from xml.etree.ElementTree import Element, SubElement

from sim_nodes.geometry import Frame, Vector, compose_frames, quaternion, roll_pitch_yaw
from sim_nodes.models import xml_reading as xml
from sim_nodes.physics import Box, Capsule, Cylinder, Hull, Shape, Sphere
from sim_nodes.views import Colour

SIZES = (0.0, 10_000.0)  # [m]
SCALES = (-1e6, 1e6)
FIELD = "height_field"  # attribute of the mesh of a height field in a translated model
SCRIPT = "script"  # attribute of a material in a translated model: an unknown name
WORLD_LINK = "__world__"  # of a translated model that is fixed to the world
OPTION = re.compile(r"\$\(optenv\s+\w+\s*([^)]*)\)")  # an environment variable, with its default


def frame_of(link: str, hung: Mapping[str, tuple[str, Frame]]) -> Frame:
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
        frame = compose_frames(origin, frame)
    raise xml.invalid(f"link {link!r} is its own ancestor, or has more than {xml.MAX_DEPTH} ancestors")


def link_of(joint: Any, tag: str, links: Mapping[str, Any]) -> str:
    """Return the name of the `parent` or `child` link of a joint, which must be known."""
    element = joint.find(tag)
    name = None if element is None else element.get("link")
    if name not in links:
        raise xml.invalid(f"{xml.label(joint)}: unknown {tag} link {name!r}")
    return str(name)


def read_origin(element: Any) -> Frame:
    """Return the frame of an element's <origin>, or the identity."""
    place, angles = read_pose(element)
    return place, quaternion(*angles)


def read_pose(element: Any) -> tuple[Vector, Vector]:
    """Return position [m] and roll, pitch, yaw [rad] of an element's <origin>; zeros without one."""
    origin = element.find("origin")
    if origin is None:
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    x, y, z = read_numbers(origin.get("xyz", "0 0 0"), f"xyz of {xml.label(element)}", 3, xml.PLACES)
    roll, pitch, yaw = read_numbers(origin.get("rpy", "0 0 0"), f"rpy of {xml.label(element)}", 3, xml.PLACES)
    return (x, y, z), (roll, pitch, yaw)


def text_of(values: Iterable[float]) -> str:
    """Return numbers as the text of an attribute, exactly."""
    return " ".join(repr(float(value)) for value in values)


def write_origin(out: Element, place: Iterable[float], angles: Iterable[float]) -> None:
    """Write an <origin> by its position [m] and roll, pitch, yaw [rad]."""
    SubElement(out, "origin", xyz=text_of(place), rpy=text_of(angles))


def write_joint(out: Element, name: str, kind: str, parent: str, child: str, frame: Frame) -> Element:
    """Write a <joint> with its frame in that of its parent link; returns it."""
    joint = SubElement(out, "joint", name=name, type=kind)
    write_origin(joint, frame[0], roll_pitch_yaw(frame[1]))
    SubElement(joint, "parent", link=parent)
    SubElement(joint, "child", link=child)
    return joint


def write_shape(out: Element, shape: Shape) -> None:
    """Write a shape, except a hull, which is a mesh in a file."""
    match shape:
        case Box(size=size):
            SubElement(out, "box", size=text_of(size))
        case Cylinder(radius=radius, length=length):
            SubElement(out, "cylinder", radius=repr(radius), length=repr(length))
        case Capsule(radius=radius, length=length):
            SubElement(out, "capsule", radius=repr(radius), length=repr(length))
        case Sphere(radius=radius):
            SubElement(out, "sphere", radius=repr(radius))
        case Hull():
            raise AssertionError("hulls are meshes in files")
        case _:
            assert_never(shape)


def mimics_of(robot: Any) -> dict[str, tuple[str, float, float]]:
    """Return the joints of a canonical URDF that follow others: leader, factor and offset by follower."""
    return {
        str(joint.get("name")): (
            str(mimic.get("joint")),
            float(mimic.get("multiplier", "1")),
            float(mimic.get("offset", "0")),
        )
        for joint in robot.findall("joint")
        for mimic in joint.findall("mimic")
    }


def paint(robot: Any, colour: Colour) -> None:
    """Give the visuals of a URDF without a colour one."""
    for visual in robot.iter("visual"):
        if visual.find("material") is None:
            material = SubElement(visual, "material", name="own")
            SubElement(material, "color", rgba=text_of(colour))


def pictures_of(robot: Any) -> dict[str, str]:
    """Return the pictures of meshes in a canonical URDF, both by the names of their files."""
    return {
        mesh.get("filename"): texture.get("filename")
        for visual in robot.iter("visual")
        for mesh in visual.iterfind("geometry/mesh")
        for texture in visual.iterfind("material/texture")
    }


def read_shape(shape: Any, what: str) -> Shape:
    """Read a shape except a mesh.

    Args:
        shape: Element in <geometry>.
        what: Text for the element around it in messages.

    Raises:
        RequestRefused: The shape is invalid or unsupported.
    """

    def length(key: str) -> float:
        return read_numbers(shape.get(key), f"{key} of <{shape.tag}> in {what}", 1, SIZES)[0]

    match shape.tag:
        case "box":
            x, y, z = read_numbers(shape.get("size"), f"size of <box> in {what}", 3, SIZES)
            return Box((x, y, z))
        case "cylinder":
            return Cylinder(length("radius"), length("length"))
        case "capsule":
            return Capsule(length("radius"), length("length"))
        case "sphere":
            return Sphere(length("radius"))
        case other:
            raise xml.invalid(
                f"unsupported <{other}> in <geometry>; "
                "expected <box>, <cylinder>, <sphere>, <capsule>, <plane> or <mesh>"
            )


def read_numbers(text: str | None, what: str, count: int | None, bounds: tuple[float, float]) -> list[float]:
    """Parse numbers between spaces or commas, or with defaults of environment variables as in ROS.

    Args:
        text: The text.
        what: Name of the numbers for errors.
        count: Number of numbers; None for any.
        bounds: Smallest and largest number.

    Raises:
        RequestRefused: The text is invalid.
    """
    clean = OPTION.sub(r"\1", text or "").replace(",", " ")
    return xml.numbers(clean, what, len(clean.split()) if count is None else count, bounds)
