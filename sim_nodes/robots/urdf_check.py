"""Checks that a robot's URDF fits its declaration and is supported by every engine.

Engines ignore errors silently: one skips unknown elements, another gives massless links a kilogram.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from typing import Any

import numpy as np
from defusedxml import ElementTree

from sim_nodes.geometry import conjugate, multiply, rotated, vector, wrap, yaw_of
from sim_nodes.manipulation.chain import Chain
from sim_nodes.models import xml_reading as xml
from sim_nodes.models.urdf import frame_of, link_of, read_origin, read_shape
from sim_nodes.physics import BodyState, Engine, Part, PlacedRobot
from sim_nodes.robots.declaration import ArmDeclaration, DriveDeclaration, MobileDeclaration, RobotDeclaration

ELEMENTS = frozenset({"link", "joint", "material"})
LINK_ELEMENTS = frozenset({"inertial", "visual", "collision"})
JOINT_ELEMENTS = frozenset({"origin", "parent", "child", "axis", "limit", "dynamics", "mimic"})
REPEATED = frozenset({"link", "joint", "material", "visual", "collision"})
JOINT_TYPES = ("fixed", "continuous", "revolute", "prismatic")
SHAPES = (1e-3, 10.0)  # [m]
MOMENTS = (1e-9, 1e4)  # [kg m^2]
LIMITS = (-1e6, 1e6)  # of joints, in their units
TOLERANCE = 1e-3  # [m], [rad] between equal values of URDF and declaration


def check_urdf(declaration: RobotDeclaration) -> None:
    """Check the URDF of a robot.

    Raises:
        RequestRefused: It has unsupported parts, or does not fit the declaration.
    """
    root = xml.parse_xml(declaration.urdf)
    if root.tag != "robot" or not root.get("name"):
        raise xml.invalid(f"invalid root element <{root.tag}>; expected <robot> with a name")
    xml.check_children(root, ELEMENTS)
    for element in root.iter():
        _check_once(element)
    links, joints = _by_name(root, "link"), _by_name(root, "joint")
    for link in links.values():
        _check_link(link)
    for joint in joints.values():
        _check_joint(joint, links)
    _check_tree(declaration, links, joints)
    _check_names(declaration, links, joints)
    if declaration.mobile is not None:
        _check_base(declaration.mobile, joints)
        _check_wheels(declaration.mobile.drive, links, joints)
    if declaration.arm is not None:
        _check_arm(declaration, declaration.arm)


def _by_name(root: Any, tag: str) -> dict[str, Any]:
    elements = root.findall(tag)
    found = {str(element.get("name")): element for element in elements if element.get("name")}
    if len(found) != len(elements):
        raise xml.invalid(f"missing or duplicate name of a <{tag}>")
    return found


def _check_once(element: Any) -> None:
    tags = [child.tag for child in element if child.tag not in REPEATED]
    again = next((tag for tag in tags if tags.count(tag) > 1), None)
    if again is not None:
        raise xml.invalid(f"{xml.label(element)} has <{again}> {tags.count(again)} times")


def _check_link(link: Any) -> None:
    xml.check_children(link, LINK_ELEMENTS)
    for element in (*link.findall("visual"), *link.findall("collision")):
        read_shape(element, SHAPES)
        read_origin(element)
    mass, inertia = link.find("inertial/mass"), link.find("inertial/inertia")
    if mass is None or inertia is None:
        raise xml.invalid(
            f"{xml.label(link)} lacks an <inertial> with <mass> and <inertia>; give a pure frame 1 g"
        )
    read_origin(link.find("inertial"))
    xml.numbers(mass.get("value"), f"mass of {xml.label(link)}", 1, xml.MASSES)
    bounds = 3 * [MOMENTS] + 3 * [(-MOMENTS[1], MOMENTS[1])]  # of moments and of products
    named = ((inertia.get(name), f"{name} of {xml.label(link)}") for name in xml.INERTIA)
    values = [xml.numbers(*each, 1, limits)[0] for each, limits in zip(named, bounds, strict=True)]
    xml.check_inertia(xml.label(link), values)


def _check_joint(joint: Any, links: Mapping[str, Any]) -> None:
    xml.check_children(joint, JOINT_ELEMENTS)
    if joint.get("type") not in JOINT_TYPES:
        raise xml.invalid(
            f"{xml.label(joint)} has the unsupported type {joint.get('type')!r}; expected {', '.join(JOINT_TYPES)}"
        )
    for tag in ("parent", "child"):
        link_of(joint, tag, links)
    read_origin(joint)
    for axis in joint.findall("axis"):
        if not any(xml.vector(axis.get("xyz"), f"axis of {xml.label(joint)}")):
            raise xml.invalid(f"zero axis of {xml.label(joint)}")
    for element in (*joint.findall("limit"), *joint.findall("dynamics")):
        for name, value in element.items():
            xml.numbers(value, f"{name} of {xml.label(joint)}", 1, LIMITS)


def _check_tree(declaration: RobotDeclaration, links: Mapping[str, Any], joints: Mapping[str, Any]) -> None:
    children = [joint.find("child").get("link") for joint in joints.values()]
    twice = next((child for child in children if children.count(child) > 1), None)
    if twice is not None:
        raise xml.invalid(f"link {twice!r} is the child of two joints")
    roots = sorted(links.keys() - set(children))
    if roots != [declaration.base_link]:
        raise xml.invalid(
            f"found root links {', '.join(roots) or 'none'}; "
            f"expected only the declaration's `base_link`, {declaration.base_link!r}"
        )


def _check_names(declaration: RobotDeclaration, links: Mapping[str, Any], joints: Mapping[str, Any]) -> None:
    mobile, arm = declaration.mobile, declaration.arm
    wanted_links = {*declaration.low_friction_links, *(camera.link for camera in declaration.cameras)}
    wanted_joints: set[str] = set()
    if mobile is not None:
        wanted_links.add(mobile.lidar.link)
        wanted_joints |= {mobile.drive.left_joint, mobile.drive.right_joint}
    if arm is not None:
        wanted_links |= {arm.tool_link, *arm.gripper.links}
        wanted_joints |= {*arm.gripper.joints, *(joint.name for joint in arm.joints)}
    _check_known("link", wanted_links, links)
    _check_known("joint", wanted_joints, joints)


def _check_arm(declaration: RobotDeclaration, arm: ArmDeclaration) -> None:
    if not declaration.fixed:
        raise xml.invalid("missing `fixed: true` in the declaration; robots with an `arm` are fixed")
    try:
        chain = Chain(declaration.urdf, declaration.base_link, arm.tool_link, [joint.name for joint in arm.joints])
    except ValueError as error:
        raise xml.invalid(str(error)) from error
    limits = chain.limits
    for joint, lower, upper, speed in zip(arm.joints, limits.lower, limits.upper, limits.speed, strict=True):
        if not 0.0 < speed < math.inf:
            raise xml.invalid(f"invalid velocity limit {speed:g} rad/s of {joint.name}; expected more than 0")
        if not lower <= joint.home <= upper:
            raise xml.invalid(
                f"invalid `home` {joint.home:.3f} rad of {joint.name}; expected {lower:.3f} to {upper:.3f} rad"
            )


def _check_known(what: str, wanted: Iterable[str], known: Mapping[str, Any]) -> None:
    missing = sorted(set(wanted) - known.keys())
    if missing:
        raise xml.invalid(f"unknown {what} {missing[0]!r} in the declaration; the URDF has {', '.join(known)}")


def _check_base(mobile: MobileDeclaration, joints: Mapping[str, Any]) -> None:
    """Check that wheels and lidar are where the declaration has them, which odometry and scans rely on."""
    drive, lidar = mobile.drive, mobile.lidar
    for name, side in ((drive.left_joint, 1.0), (drive.right_joint, -1.0)):
        if joints[name].get("type") != "continuous":
            raise xml.invalid(f"{xml.label(joints[name])} turns a wheel; expected type 'continuous'")
        (x, y, _), _ = _place(joints[name].find("child").get("link"), joints)
        wanted = side * drive.wheel_separation / 2
        if abs(x) > TOLERANCE or abs(y - wanted) > TOLERANCE:
            raise xml.invalid(
                f"the wheel of {xml.label(joints[name])} is at ({x:.4f}, {y:.4f}) of the base; "
                f"expected (0, {wanted:.4f}) by the declaration's `wheel_separation`"
            )
    (x, y, _), orientation = _place(lidar.link, joints)
    yaw = yaw_of(orientation)
    if max(abs(x - lidar.x), abs(y - lidar.y), abs(wrap(yaw - lidar.yaw))) > TOLERANCE:
        raise xml.invalid(
            f"link {lidar.link!r} is at ({x:.4f}, {y:.4f}) of the base, turned by {yaw:.4f} rad; "
            f"expected ({lidar.x:.4f}, {lidar.y:.4f}), turned by {lidar.yaw:.4f} rad, as declared"
        )


def _check_wheels(drive: DriveDeclaration, links: Mapping[str, Any], joints: Mapping[str, Any]) -> None:
    """Check that wheels have the declared radius, which speeds rely on."""
    for name in (drive.left_joint, drive.right_joint):
        link = links[joints[name].find("child").get("link")]
        for shape in (*link.findall("collision/geometry/cylinder"), *link.findall("collision/geometry/sphere")):
            (radius,) = xml.numbers(shape.get("radius"), f"radius of the wheel {xml.label(link)}", 1, SHAPES)
            if abs(radius - drive.wheel_radius) > TOLERANCE:
                raise xml.invalid(
                    f"the wheel {xml.label(link)} has a radius of {radius:.4f} m; `wheel_radius` declares "
                    f"{drive.wheel_radius:.4f} m"
                )


def _place(link: str, joints: Mapping[str, Any]) -> xml.Frame:
    """Return the frame of a link in that of the base, with all joints at zero."""
    hung = {
        joint.find("child").get("link"): (joint.find("parent").get("link"), read_origin(joint))
        for joint in joints.values()
    }
    return frame_of(link, hung)


def line_of(urdf: str, message: str) -> int | None:
    """Return the first line of a URDF with the element named in a message; None without one."""
    found = re.search(r"<(\w+) name='([^']*)'>", message)
    if found is None:
        return None
    tag, name = map(re.escape, found.groups())
    there = re.search(rf"<{tag}\b[^>]*\bname\s*=\s*[\"']{name}[\"']", urdf)
    return None if there is None else urdf.count("\n", 0, there.start()) + 1


@cache
def link_parts(declaration: RobotDeclaration) -> Mapping[str, tuple[Part, ...]]:
    """Return the collision shapes of each link, in the link's frame, by link name."""
    root = ElementTree.fromstring(declaration.urdf)
    return {
        link.get("name", ""): tuple(
            Part(read_shape(collision, SHAPES), *read_origin(collision)) for collision in link.findall("collision")
        )
        for link in root.findall("link")
    }


def parts_of_robot(engine: Engine, robot: PlacedRobot, base: BodyState) -> Iterator[Part]:
    """Yield the collision shapes of a robot in its present posture, in the frame of its base."""
    back = conjugate(base.orientation)
    for link, parts in link_parts(robot.declaration).items():
        position, orientation = engine.link_pose(robot.name, link)
        place = rotated(back, vector(np.subtract(position, base.position)))
        yield from (part.placed(place, multiply(back, orientation)) for part in parts)
