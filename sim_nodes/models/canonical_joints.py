"""Joints of canonical models: the tree of links, and the elements of a joint."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from seoro.bridges.wire.refusal import name_list
from sim_nodes.geometry import Array, Vector
from sim_nodes.models import xml_reading as xml
from sim_nodes.models.urdf import SCALES, link_of, read_numbers, read_pose, text_of, write_origin

JOINTS = ("continuous", "fixed", "floating", "planar", "prismatic", "revolute", "spherical")
JOINT_ELEMENTS = {"origin", "parent", "child", "axis", "limit", "dynamics", "mimic"}
LIMITS = (-1e12, 1e12)  # of joints, in their units


def root_of(links: Mapping[Any, Any], children: Sequence[str]) -> str:
    """Return the name of the root link; every other link is the child of one joint.

    Args:
        links: Elements of the links by name.
        children: Name of the child link of each joint.

    Raises:
        RequestRefused: A link has several parents, or the model has no root or several.
    """
    twice = next((child for child, count in Counter(children).items() if count > 1), None)
    if twice is not None:
        raise xml.invalid(f"link {twice!r} is the child of two joints")
    roots = [str(name) for name in links if name not in children]
    if len(roots) != 1:
        raise xml.invalid(f"found {len(roots)} root links in the model: {name_list(roots)}; expected one")
    return roots[0]


def ends_of(joint: Any, links: Mapping[Any, Any]) -> tuple[str, str]:
    """Return parent and child link of a joint.

    Raises:
        RequestRefused: A link is unknown, or the joint has no name or an unknown type.
    """
    if not joint.get("name"):
        raise xml.invalid("missing name of a <joint>")
    if joint.get("type") not in JOINTS:
        raise xml.invalid(
            f"{xml.label(joint)} has the unknown type {joint.get('type')!r}; expected {name_list(JOINTS)}"
        )
    return link_of(joint, "parent", links), link_of(joint, "child", links)


def write_joint(robot: Element, joint: Any, parent: str, child: str, note: Callable[[str], None]) -> None:
    """Write a joint in canonical form.

    Args:
        robot: Element of the canonical model.
        joint: Element of the joint in its file.
        parent: Name of its parent link.
        child: Name of its child link.
        note: Takes notes of changes.

    Raises:
        RequestRefused: A number is invalid.
    """
    kind, name = joint.get("type"), joint.get("name")
    limit = joint.find("limit")
    low, high, effort, speed = (
        0.0 if limit is None else read_numbers(limit.get(key, "0"), f"{key} of {xml.label(joint)}", 1, LIMITS)[0]
        for key in ("lower", "upper", "effort", "velocity")
    )
    if kind == "revolute" and low >= high:
        note(f"{xml.label(joint)} turns freely, because its lower limit is not below its upper one")
        kind = "continuous"
    out = SubElement(robot, "joint", name=name, type=kind)
    write_pose(out, *read_pose(joint))
    SubElement(out, "parent", link=parent)
    SubElement(out, "child", link=child)
    if kind == "fixed":
        return
    SubElement(out, "axis", xyz=text_of(_axis(joint)))
    if limit is not None:
        SubElement(out, "limit", _limits(kind, low, high, effort, speed))
    for dynamics in joint.findall("dynamics"):
        values = {
            key: read_numbers(dynamics.get(key, "0"), f"{key} of {xml.label(joint)}", 1, LIMITS)[0]
            for key in ("damping", "friction")
        }
        SubElement(out, "dynamics", {key: repr(max(value, 0.0)) for key, value in values.items()})
    for mimic in joint.findall("mimic"):
        factor, offset = (
            read_numbers(mimic.get(key, usual), f"{key} of {xml.label(joint)}", 1, LIMITS)[0]
            for key, usual in (("multiplier", "1"), ("offset", "0"))
        )
        SubElement(out, "mimic", joint=mimic.get("joint", ""), multiplier=repr(factor), offset=repr(offset))


def _limits(kind: str, low: float, high: float, effort: float, speed: float) -> dict[str, str]:
    """Return the attributes of a <limit>; efforts and speeds of 0 are placeholders in many files."""
    limits = {"effort": effort, "velocity": speed}
    known = {key: repr(value) for key, value in limits.items() if value > 0.0}
    if kind in ("revolute", "prismatic") and low < high:
        known |= {"lower": repr(low), "upper": repr(high)}
    return known


def _axis(joint: Any) -> Array:
    """Return the unit vector of a joint's axis, shape (3,)."""
    element = joint.find("axis")
    values = (
        [1.0, 0.0, 0.0]
        if element is None
        else read_numbers(element.get("xyz"), f"axis of {xml.label(joint)}", 3, SCALES)
    )
    length = math.hypot(*values)
    if not length:
        raise xml.invalid(f"zero length: axis of {xml.label(joint)}")
    return np.array(values) / length


def write_pose(out: Element, place: Vector, angles: Vector) -> None:
    """Write the <origin> of an element, unless it is that of its parent: position [m] and angles [rad]."""
    if any((*place, *angles)):
        write_origin(out, place, angles)
