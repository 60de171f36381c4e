"""Transforms of the links of a robot, from its URDF and joint positions, as robot_state_publisher has them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any
from xml.etree.ElementTree import Element

from defusedxml import ElementTree

from seoro.bridges.ros2.geometry import header
from seoro.robotics.geometry import Quaternion, quaternion
from seoro.robotics.transform import IDENTITY, Transform, Vector

REVOLUTE, PRISMATIC = ("revolute", "continuous"), "prismatic"


@dataclass(frozen=True)
class Joint:
    """A joint of a URDF: its parent and child links, its origin in the parent, and its axis and speed limit."""

    name: str
    kind: str
    parent: str
    child: str
    origin: Transform
    axis: Vector
    speed: float  # [rad/s, m/s]

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
    """Links of a robot."""

    joints: tuple[Joint, ...]

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
    """Parse the text of a URDF that a simulator node has checked."""
    return Links(tuple(_joint(element) for element in ElementTree.fromstring(urdf).iter("joint")))


def _joint(element: Element) -> Joint:
    return Joint(
        name=element.get("name", ""),
        kind=element.get("type", "fixed"),
        parent=_link(element, "parent"),
        child=_link(element, "child"),
        origin=Transform(
            _numbers(element, "origin", "xyz", (0.0, 0.0, 0.0)),
            quaternion(*_numbers(element, "origin", "rpy", (0.0, 0.0, 0.0))),
        ),
        axis=_numbers(element, "axis", "xyz", (1.0, 0.0, 0.0)),
        speed=_speed(element),
    )


def _speed(element: Element) -> float:
    found = element.find("limit")
    return math.inf if found is None else float(found.get("velocity", math.inf))


def _link(element: Element, end: str) -> str:
    found = element.find(end)
    return "" if found is None else found.get("link", "")


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
