"""Joints of a URDF, and transforms of its links from joint positions, as robot_state_publisher has them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any
from xml.etree.ElementTree import Element

from defusedxml import DefusedXmlException, ElementTree

from seoro.bridges.ros2.geometry import header
from seoro.robotics.geometry import Quaternion, quaternion
from seoro.robotics.transform import IDENTITY, Transform, Vector

REVOLUTE, PRISMATIC = ("revolute", "continuous"), "prismatic"


@dataclass(frozen=True)
class Joint:
    """A joint of a URDF: its parent and child links, its origin in the parent, its axis and its limits.

    Attributes:
        speed: Maximum speed [rad/s, m/s]; infinite if it is not stated.
        limits: Lowest and highest position [rad, m]; None without limits.
        mimics: Name of the joint that it follows; empty if it moves by itself.
    """

    name: str
    kind: str
    parent: str
    child: str
    origin: Transform
    axis: Vector
    speed: float = math.inf
    limits: tuple[float, float] | None = None
    mimics: str = ""

    @property
    def moves(self) -> bool:
        """Whether the child moves relative to the parent."""
        return self.kind in REVOLUTE or self.kind == PRISMATIC

    def transform(self, position: float, time: float) -> dict[str, Any]:
        """Make a `geometry_msgs/TransformStamped` for a joint position [rad, m] and a time [s]."""
        found = self.origin
        if self.kind in REVOLUTE:
            found @= Transform(IDENTITY.translation, _about(self.axis, position))
        elif self.kind == PRISMATIC:
            x, y, z = self.axis
            found @= Transform((x * position, y * position, z * position), IDENTITY.rotation)
        x, y, z = found.translation
        rotation = Quaternion(*found.rotation)._asdict()
        return {
            "header": header(self.parent, time),
            "child_frame_id": self.child,
            "transform": {"translation": {"x": x, "y": y, "z": z}, "rotation": rotation},
        }


@dataclass(frozen=True)
class Links:
    """Links of a robot, and its name."""

    joints: tuple[Joint, ...]
    robot: str = ""

    def fixed(self) -> list[dict[str, Any]]:
        """Return the transforms of fixed joints."""
        return [joint.transform(0.0, 0.0) for joint in self.joints if not joint.moves]

    def moving(self, positions: Mapping[str, float], time: float) -> list[dict[str, Any]]:
        """Return the transforms of moving joints with known positions [rad, m], at a time [s]."""
        return [
            joint.transform(positions[joint.name], time)
            for joint in self.joints
            if joint.moves and joint.name in positions
        ]


def read_links(urdf: str) -> Links:
    """Parse the text of a URDF.

    Raises:
        ValueError: The text is invalid XML, or has an invalid number.
    """
    try:
        root = ElementTree.fromstring(urdf)
    except (ElementTree.ParseError, DefusedXmlException) as error:
        raise ValueError(f"invalid URDF: {error}") from error
    # Joints of the robot itself: those of transmissions and of ros2_control have the same tag.
    return Links(tuple(_joint(element) for element in root.findall("joint")), root.get("name", ""))


def _joint(element: Element) -> Joint:
    return Joint(
        name=element.get("name", ""),
        kind=element.get("type", "fixed"),
        parent=_attribute(element, "parent", "link"),
        child=_attribute(element, "child", "link"),
        origin=Transform(
            _numbers(element, "origin", "xyz", (0.0, 0.0, 0.0)),
            quaternion(*_numbers(element, "origin", "rpy", (0.0, 0.0, 0.0))),
        ),
        axis=_numbers(element, "axis", "xyz", (1.0, 0.0, 0.0)),
        speed=float(_attribute(element, "limit", "velocity") or math.inf),
        limits=_limits(element),
        mimics=_attribute(element, "mimic", "joint"),
    )


def _limits(element: Element) -> tuple[float, float] | None:
    if element.get("type") == "continuous" or element.find("limit") is None:
        return None
    lowest, highest = (float(_attribute(element, "limit", side) or 0.0) for side in ("lower", "upper"))
    return (lowest, highest) if lowest < highest else None


def _attribute(element: Element, name: str, attribute: str) -> str:
    found = element.find(name)
    return "" if found is None else found.get(attribute, "")


def _numbers(element: Element, name: str, attribute: str, default: Vector) -> Vector:
    found = element.find(name)
    text = None if found is None else found.get(attribute)
    if text is None:
        return default
    x, y, z = (float(number) for number in text.split())
    return x, y, z


def _about(axis: Vector, angle: float) -> Quaternion:
    """Return the rotation about an axis by an angle [rad]."""
    length = math.hypot(*axis)
    sine = math.sin(angle / 2.0) / length
    return Quaternion(axis[0] * sine, axis[1] * sine, axis[2] * sine, math.cos(angle / 2.0))
