"""Checks that a robot's URDF fits its declaration, and its solid shapes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import lru_cache
from typing import Any

from defusedxml import ElementTree

from sim_nodes.geometry import Frame, wrap, yaw_of
from sim_nodes.manipulation.chain import Chain, Limits, joint_limits
from sim_nodes.models import xml_reading as xml
from sim_nodes.models.stl import hull_of_stl
from sim_nodes.models.urdf import frame_of, read_origin, read_shape
from sim_nodes.physics import Part, Shape, Urdf
from sim_nodes.robots.declaration import ArmDeclaration, LidarDeclaration, MobileDeclaration, RobotDeclaration
from sim_nodes.robots.derive.model import read_model
from sim_nodes.robots.derive.wheels import wheel_place
from sim_nodes.robots.drive_declaration import DifferentialDrive, DriveDeclaration, PlanarDrive
from sim_nodes.robots.kinematics import motor_joints
from sim_nodes.robots.postures import Posture
from sim_nodes.robots.sensor_declarations import ForceTorqueDeclaration

TOLERANCE = 1e-3  # [m], [rad] between equal values of URDF and declaration


def check_urdf(declaration: RobotDeclaration) -> None:
    """Check that the canonical URDF of a robot fits its declaration.

    Raises:
        RequestRefused: It does not.
    """
    root = ElementTree.fromstring(declaration.urdf)
    links, joints = ({str(each.get("name")): each for each in root.findall(tag)} for tag in ("link", "joint"))
    _check_root(declaration, links, joints)
    _check_names(declaration, links, joints)
    if declaration.mobile is not None:
        _check_base(declaration, declaration.mobile, joints)
        _check_wheels(declaration.mobile.drive, links, joints)
    if declaration.arm is not None:
        _check_arm(declaration, declaration.arm)
    elif declaration.postures:
        raise xml.invalid("`postures` of a robot without joints to move; expected `arm`, or `drive: joints`")


def _check_root(declaration: RobotDeclaration, links: Mapping[str, Any], joints: Mapping[str, Any]) -> None:
    [root] = links.keys() - {joint.find("child").get("link") for joint in joints.values()}
    if root != declaration.base_link:
        raise xml.invalid(
            f"found the root link {root}; expected the declaration's `base_link`, {declaration.base_link!r}"
        )


def _check_names(declaration: RobotDeclaration, links: Mapping[str, Any], joints: Mapping[str, Any]) -> None:
    mobile, arm = declaration.mobile, declaration.arm
    carried = (*declaration.cameras, *declaration.sensors)
    wanted_links = {*declaration.low_friction_links, *(each.link for each in carried)}
    wanted_joints: set[str] = set()
    if mobile is not None:
        if mobile.lidar is not None:
            wanted_links.add(mobile.lidar.link)
        wanted_joints |= {*motor_joints(mobile.drive)}
    if arm is not None:
        wanted_links |= {*arm.finger_links} | ({arm.tool_link} if arm.tool_link is not None else set())
        wanted_joints |= {*arm.fingers, *(joint.name for joint in arm.joints)}
    _check_known("link", wanted_links, links)
    fixed = {joint.find("child").get("link") for joint in joints.values() if joint.get("type") == "fixed"}
    for sensor in declaration.sensors:
        if isinstance(sensor, ForceTorqueDeclaration) and sensor.link not in fixed:
            raise xml.invalid(
                f"the force-torque sensor {sensor.name!r} is on {sensor.link!r}; expected the child of a "
                f"fixed joint ({', '.join(sorted(fixed)) or 'the robot has none'})"
            )
    _check_known("joint", wanted_joints, joints)


def _check_arm(declaration: RobotDeclaration, arm: ArmDeclaration) -> None:
    if arm.tool_link is not None and not declaration.fixed and declaration.mobile is None:
        raise xml.invalid(
            "missing `fixed: true` in the declaration; an arm is fixed, or carried by a `mobile` base"
        )
    names = [joint.name for joint in arm.joints]
    try:
        if arm.tool_link is None:
            limits = joint_limits(declaration.urdf, names)
        else:
            limits = Chain(declaration.urdf, declaration.base_link, arm.tool_link, names).limits
    except ValueError as error:
        raise xml.invalid(str(error)) from error
    for joint, lower, upper, speed, unit in zip(
        arm.joints, limits.lower, limits.upper, limits.speed, limits.units, strict=True
    ):
        if not 0.0 < speed < math.inf:
            raise xml.invalid(f"invalid velocity limit {speed:g} {unit}/s of {joint.name}; expected more than 0")
        if not lower <= joint.home <= upper:
            raise xml.invalid(
                f"invalid `home` {joint.home:.3f} {unit} of {joint.name}; "
                f"expected {lower:.3f} to {upper:.3f} {unit}"
            )
    for posture in declaration.postures:
        _check_posture(posture, names, limits)


def _check_posture(posture: Posture, names: Sequence[str], limits: Limits) -> None:
    try:
        positions = posture.of(names)
    except ValueError as error:
        raise xml.invalid(str(error)) from error
    for name, lower, upper, unit in zip(names, limits.lower, limits.upper, limits.units, strict=True):
        if not lower <= positions.get(name, lower) <= upper:
            raise xml.invalid(
                f"invalid `postures.{posture.name}` {positions[name]:.3f} {unit} of {name}; "
                f"expected {lower:.3f} to {upper:.3f} {unit}"
            )


def _check_known(what: str, wanted: Iterable[str], known: Mapping[str, Any]) -> None:
    missing = sorted(set(wanted) - known.keys())
    if missing:
        raise xml.invalid(f"unknown {what} {missing[0]!r} in the declaration; the URDF has {', '.join(known)}")


def _check_base(declaration: RobotDeclaration, mobile: MobileDeclaration, joints: Mapping[str, Any]) -> None:
    """Check that wheels and lidar are where the declaration has them, which odometry and scans rely on."""
    model = read_model(Urdf(declaration.urdf, dict(declaration.meshes), (), {}))
    for name, *wanted in _declared_wheels(mobile.drive):
        joint = joints[name]
        if joint.get("type") != "continuous":
            raise xml.invalid(f"{xml.label(joint)} turns a wheel; expected type 'continuous'")
        x, y = wheel_place(model, joint.find("child").get("link"))
        if math.dist((x, y), wanted) > TOLERANCE:
            declared = "wheel_separation" if isinstance(mobile.drive, DifferentialDrive) else "wheels"
            raise xml.invalid(
                f"the wheel of {xml.label(joint)} is at ({x:.4f}, {y:.4f}) of the base; "
                f"expected ({wanted[0]:g}, {wanted[1]:.4f}) by the declaration's `{declared}`"
            )
    if mobile.lidar is not None:
        _check_lidar(mobile.lidar, joints)


def _check_lidar(lidar: LidarDeclaration, joints: Mapping[str, Any]) -> None:
    (x, y, _), orientation = _place(lidar.link, joints)
    yaw = yaw_of(orientation)
    if max(abs(x - lidar.x), abs(y - lidar.y), abs(wrap(yaw - lidar.yaw))) > TOLERANCE:
        raise xml.invalid(
            f"link {lidar.link!r} is at ({x:.4f}, {y:.4f}) of the base, turned by {yaw:.4f} rad; "
            f"expected ({lidar.x:.4f}, {lidar.y:.4f}), turned by {lidar.yaw:.4f} rad, as declared"
        )


def _declared_wheels(drive: DriveDeclaration) -> Iterator[tuple[str, float, float]]:
    """Yield the joint and the declared place of each wheel in the base's frame [m]."""
    if isinstance(drive, PlanarDrive):
        yield from ((wheel.joint, wheel.x, wheel.y) for wheel in drive.wheels)
    else:
        yield drive.left_joint, 0.0, drive.wheel_separation / 2
        yield drive.right_joint, 0.0, -drive.wheel_separation / 2


def _check_wheels(drive: DriveDeclaration, links: Mapping[str, Any], joints: Mapping[str, Any]) -> None:
    """Check that wheels have the declared radius, which speeds rely on."""
    if isinstance(drive, PlanarDrive):
        radii = {wheel.joint: wheel.radius for wheel in drive.wheels}
    else:
        radii = dict.fromkeys((drive.left_joint, drive.right_joint), drive.wheel_radius)
    name_of_radius = "radius" if isinstance(drive, PlanarDrive) else "wheel_radius"
    for name, declared in radii.items():
        link = links[joints[name].find("child").get("link")]
        for shape in (*link.findall("collision/geometry/cylinder"), *link.findall("collision/geometry/sphere")):
            radius = float(shape.get("radius"))
            if abs(radius - declared) > TOLERANCE:
                raise xml.invalid(
                    f"the wheel {xml.label(link)} has a radius of {radius:.4f} m; `{name_of_radius}` declares "
                    f"{declared:.4f} m"
                )


def _place(link: str, joints: Mapping[str, Any]) -> Frame:
    """Return the frame of a link in that of the base, with all joints at zero."""
    hung = {
        joint.find("child").get("link"): (joint.find("parent").get("link"), read_origin(joint))
        for joint in joints.values()
    }
    return frame_of(link, hung)


@lru_cache(maxsize=16)
def link_parts(declaration: RobotDeclaration) -> Mapping[str, tuple[Part, ...]]:
    """Return the collision shapes of each link, in the link's frame, by link name."""
    root = ElementTree.fromstring(declaration.urdf)
    return {
        link.get("name", ""): tuple(
            Part(_shape(collision, declaration), *read_origin(collision))
            for collision in link.findall("collision")
        )
        for link in root.findall("link")
    }


def _shape(collision: Any, declaration: RobotDeclaration) -> Shape:
    [shape] = collision.find("geometry")
    if shape.tag == "mesh":
        return hull_of_stl(dict(declaration.meshes)[shape.get("filename")])
    return read_shape(shape, xml.label(collision))
