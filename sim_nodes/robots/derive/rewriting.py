"""Changes of a robot's URDF that its drive needs: the frame of the base, directions of joints, and wheels."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any
from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np
from defusedxml import ElementTree

from seoro.deferred import dataclass
from sim_nodes.geometry import conjugate, quaternion, rotated, vector
from sim_nodes.models.urdf import text_of, write_joint, write_origin, write_shape
from sim_nodes.physics import Cylinder
from sim_nodes.robots.derive.drives import DerivedDrive
from sim_nodes.robots.derive.model import RobotModel
from sim_nodes.robots.derive.wheels import Wheel
from sim_nodes.robots.drive_declaration import DriveKind

FOOTPRINT = "base_footprint"  # name of a base on the floor, by REP 120
FRAME_MASS, FRAME_INERTIA = "0.001", "1e-06"  # [kg], [kg m^2]


@dataclass(frozen=True)
class Changes:
    """Changes of a URDF.

    Attributes:
        root: Root link of the model.
        base: Link of the base: the root, or a new one below it.
        offset: Frame of the root in that of the new base: place [m], and roll, pitch, yaw [rad].
        reversed: Joints that turn about the opposite axis.
        held: Joints that become fixed.
        round_wheels: Wheels whose solid meshes become cylinders.
    """

    root: str
    base: str
    offset: tuple[tuple[float, float, float], tuple[float, float, float]]
    reversed: frozenset[str]
    held: frozenset[str]
    round_wheels: tuple[Wheel, ...]

    @property
    def notes(self) -> tuple[str, ...]:
        """Texts on the changes."""
        found = []
        if self.base != self.root:
            found.append(f"the base is the new link {self.base!r}, on the floor at the centre of the drive")
        if self.reversed:
            found.append(f"turned the axes of {_names(self.reversed)}, so that wheels turn ahead and steer left")
        if self.held:
            found.append(f"without a motor, so held at 0: {_names(self.held)}")
        if self.round_wheels:
            found.append(f"meshes of wheels roll as cylinders: {_names(w.joint.child for w in self.round_wheels)}")
        return tuple(found)


def _names(names: Iterable[str]) -> str:
    return ", ".join(sorted(names))


def changes_for(model: RobotModel, derived: DerivedDrive, kept: frozenset[str]) -> Changes:
    """Return the changes for a drive.

    Args:
        model: Model of the robot.
        derived: Its drive.
        kept: Names of other joints that move, such as those of an arm.
    """
    base, wheels = derived.base, derived.wheels
    motors = {joint.name for joint in derived.motors}
    backwards = {wheel.joint.name for wheel in wheels if wheel.turns_backwards}
    if derived.drive.kind is DriveKind.ACKERMANN:
        steering = [wheel.steering for wheel in wheels if wheel.steering is not None]
        backwards |= {joint.name for joint in steering if joint.axis[2] < 0.0}
    (x, y), z = base.place((0.0, 0.0, 0.0)), -base.floor
    return Changes(
        model.root,
        model.root if base.is_root else next(name for name in _candidates() if name not in model.frames),
        ((x, y, z), (0.0, 0.0, -base.yaw)),
        frozenset(backwards),
        frozenset(each.name for each in model.joints.values() if each.is_movable) - motors - kept,
        tuple(wheel for wheel in wheels if not wheel.is_exact),
    )


def _candidates() -> Iterable[str]:
    yield FOOTPRINT
    number = 2
    while True:
        yield f"{FOOTPRINT}_{number}"
        number += 1


def canonical_text(model: RobotModel, changes: Changes) -> str:
    """Return the canonical URDF with the changes."""
    root: Any = ElementTree.fromstring(model.urdf.text)
    for wheel in changes.round_wheels:
        _make_round(root, model, wheel)
    return _changed(root, changes, is_canonical=True)


def source_text(text: str, changes: Changes) -> str:
    """Return the text of a URDF with the changes that concern its links and joints."""
    return _changed(ElementTree.fromstring(text), changes, is_canonical=False)


def _changed(root: Any, changes: Changes, *, is_canonical: bool) -> str:
    for joint in root.findall("joint"):
        if joint.get("name") in changes.held:
            hold_joint(joint)
        elif joint.get("name") in changes.reversed:
            _reverse(joint)
    if changes.base != changes.root:
        link = SubElement(root, "link", name=changes.base)
        if is_canonical:
            inertial = SubElement(link, "inertial")
            SubElement(inertial, "mass", value=FRAME_MASS)
            moments = dict.fromkeys(("ixx", "iyy", "izz"), FRAME_INERTIA)
            SubElement(inertial, "inertia", {**moments, "ixy": "0", "ixz": "0", "iyz": "0"})
        place, angles = changes.offset
        write_joint(
            root, f"{changes.base}_joint", "fixed", changes.base, changes.root, (place, quaternion(*angles))
        )
    return urdf_text(root)


def urdf_text(root: Element) -> str:
    """Return the text of a URDF, with an element on each line."""
    return tostring(root, encoding="unicode").replace("><", ">\n<")


def hold_joint(joint: Element) -> None:
    """Fix a joint at zero."""
    joint.set("type", "fixed")
    for tag in ("axis", "limit", "dynamics", "mimic"):
        for element in joint.findall(tag):
            joint.remove(element)


def _reverse(joint: Element) -> None:
    axis = joint.find("axis")
    if axis is None:
        axis = SubElement(joint, "axis", xyz="1 0 0")
    axis.set("xyz", text_of(-float(value) for value in (axis.get("xyz") or "1 0 0").split()))
    limit = joint.find("limit")
    if limit is not None and "lower" in limit.attrib and "upper" in limit.attrib:
        lower, upper = limit.attrib["lower"], limit.attrib["upper"]
        limit.attrib |= {"lower": repr(-float(upper)), "upper": repr(-float(lower))}


def _make_round(root: Any, model: RobotModel, wheel: Wheel) -> None:
    """Replace the solid shapes of a wheel, also of links fixed to it, by a cylinder."""
    links = {str(each.get("name")): each for each in root.findall("link")}
    turning = wheel.joint.child
    for name, link in links.items():
        if model.carrier(name) == turning:
            for collision in link.findall("collision"):
                link.remove(collision)
    position, orientation = model.frames[turning]
    back = conjugate(orientation)
    x, y, z = rotated(back, wheel.joint.axis)
    collision = SubElement(links[turning], "collision")
    centre = rotated(back, vector(np.subtract(wheel.centre, position)))
    write_origin(collision, centre, (0.0, math.acos(max(-1.0, min(z, 1.0))), math.atan2(y, x)))
    write_shape(SubElement(collision, "geometry"), Cylinder(wheel.radius, wheel.width))
