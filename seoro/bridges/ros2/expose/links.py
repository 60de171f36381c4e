"""Where the links of a robot are, by its URDF and the positions of its joints (as robot_state_publisher does)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any
from xml.etree.ElementTree import Element

from defusedxml import ElementTree

from seoro.bridges.ros2.geometry import Quaternion, header, quaternion

TURNING, SLIDING = ("revolute", "continuous"), "prismatic"

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Joint:
    """A joint of a URDF: the child link in the frame of the parent, and how it moves."""

    name: str
    kind: str
    parent: str
    child: str
    place: Vector  # [m]
    turn: Quaternion
    axis: Vector
    speed: float  # that it can have [rad/s, m/s]

    @property
    def moves(self) -> bool:
        """Whether the child moves against the parent."""
        return self.kind in TURNING or self.kind == SLIDING

    def transform(self, position: float, time: float) -> dict[str, Any]:
        """A `geometry_msgs/TransformStamped` of a position [rad, m] at a time [s]."""
        (x, y, z), turn = self.place, self.turn
        if self.kind in TURNING:
            turn = turn.times(_about(self.axis, position))
        elif self.kind == SLIDING:
            dx, dy, dz = turn.turned(*(part * position for part in self.axis))
            x, y, z = x + dx, y + dy, z + dz
        return {
            "header": header(self.parent, time),
            "child_frame_id": self.child,
            "transform": {"translation": {"x": x, "y": y, "z": z}, "rotation": turn._asdict()},
        }


@dataclass(frozen=True)
class Links:
    """The links of a robot."""

    joints: tuple[Joint, ...]

    def fixed(self) -> list[dict[str, Any]]:
        """The transforms that never change."""
        return [joint.transform(0.0, 0.0) for joint in self.joints if not joint.moves]

    def moving(self, positions: Mapping[str, float], time: float) -> list[dict[str, Any]]:
        """Those of joints whose positions [rad, m] are known, at a time [s]."""
        return [
            joint.transform(positions[joint.name], time)
            for joint in self.joints
            if joint.moves and joint.name in positions
        ]


def read_links(urdf: str) -> Links:
    """The links in the text of a URDF that a simulator node has checked."""
    return Links(tuple(_joint(element) for element in ElementTree.fromstring(urdf).iter("joint")))


def _joint(element: Element) -> Joint:
    return Joint(
        name=element.get("name", ""),
        kind=element.get("type", "fixed"),
        parent=_link(element, "parent"),
        child=_link(element, "child"),
        place=_numbers(element, "origin", "xyz", (0.0, 0.0, 0.0)),
        turn=quaternion(*_numbers(element, "origin", "rpy", (0.0, 0.0, 0.0))),
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
    length = math.hypot(*axis)
    sine = math.sin(angle / 2.0) / length
    return Quaternion(axis[0] * sine, axis[1] * sine, axis[2] * sine, math.cos(angle / 2.0))
