"""Whether a robot's URDF is what its declaration says, and what every engine can simulate.

Engines forgive much in silence: one leaves out what it does not know, another gives links without mass a kilogram.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from typing import Any

from sim_nodes.geometry import wrap, yaw_of
from sim_nodes.manipulation.chain import Chain
from sim_nodes.models.reading import (
    MASSES,
    MAX_DEPTH,
    ORIGIN,
    Frame,
    check_children,
    check_inertia,
    inside,
    named,
    numbers,
    parse_xml,
    symmetric,
    vector,
    wrong,
)
from sim_nodes.models.urdf import read_origin, read_shape
from sim_nodes.robots.declaration import ArmDeclaration, DriveDeclaration, MobileDeclaration, RobotDeclaration

ELEMENTS = frozenset({"link", "joint", "material"})
LINK_ELEMENTS = frozenset({"inertial", "visual", "collision"})
JOINT_ELEMENTS = frozenset({"origin", "parent", "child", "axis", "limit", "dynamics", "mimic"})
REPEATED = frozenset({"link", "joint", "material", "visual", "collision"})
JOINT_TYPES = ("fixed", "continuous", "revolute", "prismatic")
SHAPES = (1e-3, 10.0)  # [m]
MOMENTS = (1e-9, 1e4)  # [kg m^2]
LIMITS = (-1e6, 1e6)  # of what a joint can do, in its units
TOLERANCE = 1e-3  # [m], [rad] between what URDF and declaration say of the same


def check_urdf(declaration: RobotDeclaration) -> None:
    """Check the URDF of a robot.

    Raises:
        RequestRefused: It has something that is not supported, or does not fit the declaration.
    """
    root = parse_xml(declaration.urdf)
    if root.tag != "robot" or not root.get("name"):
        raise wrong(f"the root element is <{root.tag}>: it has to be <robot> with a name")
    check_children(root, ELEMENTS)
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
        raise wrong(f"each <{tag}> has to have a name of its own")
    return found


def _check_once(element: Any) -> None:
    tags = [child.tag for child in element if child.tag not in REPEATED]
    again = next((tag for tag in tags if tags.count(tag) > 1), None)
    if again is not None:
        raise wrong(f"{named(element)} has <{again}> {tags.count(again)} times")


def _check_link(link: Any) -> None:
    check_children(link, LINK_ELEMENTS)
    for element in (*link.findall("visual"), *link.findall("collision")):
        read_shape(element, SHAPES)
        read_origin(element)
    mass, inertia = link.find("inertial/mass"), link.find("inertial/inertia")
    if mass is None or inertia is None:
        raise wrong(f"{named(link)} has to have an <inertial> with <mass> and <inertia>; give a mere frame a gram")
    read_origin(link.find("inertial"))
    numbers(mass.get("value"), f"mass of {named(link)}", 1, MASSES)
    for moment in ("ixx", "iyy", "izz"):
        numbers(inertia.get(moment), f"{moment} of {named(link)}", 1, MOMENTS)
    for product in ("ixy", "ixz", "iyz"):
        numbers(inertia.get(product), f"{product} of {named(link)}", 1, (-MOMENTS[1], MOMENTS[1]))
    elements = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    check_inertia(named(link), symmetric([float(inertia.get(each)) for each in elements]))


def _check_joint(joint: Any, links: Mapping[str, Any]) -> None:
    check_children(joint, JOINT_ELEMENTS)
    if joint.get("type") not in JOINT_TYPES:
        raise wrong(f"{named(joint)} is of type {joint.get('type')!r}: supported are {', '.join(JOINT_TYPES)}")
    for tag in ("parent", "child"):
        element = joint.find(tag)
        name = None if element is None else element.get("link")
        if name not in links:
            raise wrong(f"{named(joint)}: there is no link {name!r} to be its {tag}")
    read_origin(joint)
    for axis in joint.findall("axis"):
        if not any(vector(axis.get("xyz"), f"axis of {named(joint)}")):
            raise wrong(f"the axis of {named(joint)} has no length")
    for element in (*joint.findall("limit"), *joint.findall("dynamics")):
        for name, value in element.items():
            numbers(value, f"{name} of {named(joint)}", 1, LIMITS)


def _check_tree(declaration: RobotDeclaration, links: Mapping[str, Any], joints: Mapping[str, Any]) -> None:
    children = [joint.find("child").get("link") for joint in joints.values()]
    twice = next((child for child in children if children.count(child) > 1), None)
    if twice is not None:
        raise wrong(f"the link {twice!r} is the child of two joints")
    roots = sorted(links.keys() - set(children))
    if roots != [declaration.base_link]:
        raise wrong(
            f"the links that hang on no other are {', '.join(roots) or 'none'}: "
            f"it has to be the `base_link` of the declaration alone, {declaration.base_link!r}"
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
        raise wrong("its declaration has an `arm`, and does not say `fixed: true`: arms stand fixed")
    try:
        chain = Chain(declaration.urdf, declaration.base_link, arm.tool_link, [joint.name for joint in arm.joints])
    except ValueError as error:
        raise wrong(str(error)) from error
    limits = chain.limits
    for joint, lower, upper, speed in zip(arm.joints, limits.lower, limits.upper, limits.speed, strict=True):
        if not 0.0 < speed < math.inf:
            raise wrong(f"the velocity limit of {joint.name} is {speed:g} rad/s: it has to be above 0")
        if not lower <= joint.home <= upper:
            raise wrong(
                f"{joint.name} goes from {lower:.3f} to {upper:.3f} rad, and its `home` is {joint.home:.3f} rad"
            )


def _check_known(what: str, wanted: Iterable[str], known: Mapping[str, Any]) -> None:
    missing = sorted(set(wanted) - known.keys())
    if missing:
        raise wrong(
            f"there is no {what} {missing[0]!r}, which the declaration names: there are {', '.join(known)}"
        )


def _check_base(mobile: MobileDeclaration, joints: Mapping[str, Any]) -> None:
    """Wheels and lidar have to be where the declaration, by which odometry and scans are computed, has them."""
    drive, lidar = mobile.drive, mobile.lidar
    for name, side in ((drive.left_joint, 1.0), (drive.right_joint, -1.0)):
        if joints[name].get("type") != "continuous":
            raise wrong(f"{named(joints[name])} turns a wheel: it has to be 'continuous'")
        (x, y, _), _ = _place(joints[name].find("child").get("link"), joints)
        wanted = side * drive.wheel_separation / 2
        if abs(x) > TOLERANCE or abs(y - wanted) > TOLERANCE:
            raise wrong(
                f"the wheel of {named(joints[name])} is at ({x:.4f}, {y:.4f}) of the base: "
                f"by the declaration's `wheel_separation` it is at (0, {wanted:.4f})"
            )
    (x, y, _), orientation = _place(lidar.link, joints)
    yaw = yaw_of(orientation)
    if max(abs(x - lidar.x), abs(y - lidar.y), abs(wrap(yaw - lidar.yaw))) > TOLERANCE:
        raise wrong(
            f"the link {lidar.link!r} is at ({x:.4f}, {y:.4f}) of the base, turned by {yaw:.4f} rad: "
            f"the declaration has the lidar at ({lidar.x:.4f}, {lidar.y:.4f}), turned by {lidar.yaw:.4f} rad"
        )


def _check_wheels(drive: DriveDeclaration, links: Mapping[str, Any], joints: Mapping[str, Any]) -> None:
    """Wheels have to be as large as the declaration, by which speeds are computed, has them."""
    for name in (drive.left_joint, drive.right_joint):
        link = links[joints[name].find("child").get("link")]
        for shape in (*link.findall("collision/geometry/cylinder"), *link.findall("collision/geometry/sphere")):
            (radius,) = numbers(shape.get("radius"), f"radius of the wheel {named(link)}", 1, SHAPES)
            if abs(radius - drive.wheel_radius) > TOLERANCE:
                raise wrong(
                    f"the wheel {named(link)} has a radius of {radius:.4f} m: the declaration's `wheel_radius` is "
                    f"{drive.wheel_radius:.4f} m"
                )


def _place(link: str, joints: Mapping[str, Any]) -> Frame:
    """The frame of a link in that of the base, all joints at zero."""
    above = {joint.find("child").get("link"): joint for joint in joints.values()}
    frame = ORIGIN
    for _ in range(MAX_DEPTH):
        if link not in above:
            return frame
        frame = inside(read_origin(above[link]), frame)
        link = above[link].find("parent").get("link")
    raise wrong(f"the link {link!r} hangs on itself, or on more than {MAX_DEPTH} others")


def line_of(urdf: str, message: str) -> int | None:
    """The line of a URDF in which what a message names first stands; None if it names nothing."""
    found = re.search(r"<(\w+) name='([^']*)'>", message)
    if found is None:
        return None
    tag, name = map(re.escape, found.groups())
    there = re.search(rf"<{tag}\b[^>]*\bname\s*=\s*[\"']{name}[\"']", urdf)
    return None if there is None else urdf.count("\n", 0, there.start()) + 1
