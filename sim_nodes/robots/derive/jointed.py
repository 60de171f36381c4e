"""Declarations of arms and of bodies that move by their joints, derived from their models."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from enum import StrEnum
from types import MappingProxyType
from typing import Any
from xml.etree.ElementTree import SubElement

from defusedxml import ElementTree

from seoro.bridges.wire.refusal import name_list
from seoro.deferred import dataclass
from sim_nodes.extents import lowest_of
from sim_nodes.models import xml_reading as xml
from sim_nodes.physics import IDENTITY, BodyState
from sim_nodes.robots.declaration import ArmDeclaration
from sim_nodes.robots.derive.grippers import Fingers, declare_gripper, find_fingers
from sim_nodes.robots.derive.model import ModelJoint, RobotModel
from sim_nodes.robots.derive.motors import DIGITS, SPEED, declare_motor, effort_of, limits_of, speed_of
from sim_nodes.robots.derive.rewriting import hold_joint, urdf_text
from sim_nodes.robots.postures import positions_by_joint

NO_POSITIONS: Mapping[str, float] = MappingProxyType({})
EDGE = 0.05  # share of the range of a joint; home is the middle if zero is nearer to a limit
WORLD = "world"  # name of a root link that stands for the world, by the convention of ROS


class JointDrive(StrEnum):
    """Kinds of position-controlled robots."""

    ARM = "arm"
    JOINTS = "joints"


KINDS = {
    JointDrive.ARM: ("manipulator", "arm", "robot", "osc_actor"),
    JointDrive.JOINTS: ("jointed_robot", "arm", "robot", "osc_actor"),
}
FRICTION = {JointDrive.ARM: 0.5, JointDrive.JOINTS: 1.0}


@dataclass(frozen=True)
class JointedRobot:
    """A robot with position-controlled joints by its model.

    Attributes:
        urdf: Canonical URDF with the limits that it lacks, and further joints held.
        base_link: Its root; that of the world is left out.
        arm: Declaration of its joints.
        standing_height: Height of the base above its lowest point at home [m]; 0 for arms.
        notes: Texts on the changes.
    """

    urdf: str
    base_link: str
    arm: ArmDeclaration
    standing_height: float
    notes: tuple[str, ...]


@dataclass(frozen=True)
class DerivedJoints:
    """Position-controlled joints of a model.

    Attributes:
        arm: Their declaration.
        moved: The joints, without fingers.
        efforts: Limits of their motors by joint [N m], [N].
    """

    arm: ArmDeclaration
    moved: tuple[ModelJoint, ...]
    efforts: Mapping[str, float]


def derive_jointed(model: RobotModel, drive: JointDrive, derived: DerivedJoints) -> JointedRobot:
    """Derive the declaration of a robot from that of its joints."""
    root: Any = ElementTree.fromstring(model.urdf.text)
    notes = (*hold_others(root, kept_joints(model, derived.arm)), *complete_limits(root, derived))
    base_link = _without_world(root, model)
    height = -_lowest(model.at(derived.arm.home)) if drive is JointDrive.JOINTS else 0.0
    return JointedRobot(urdf_text(root), base_link, derived.arm, round(max(0.0, height), DIGITS), notes)


def derive_joints(
    model: RobotModel,
    drive: JointDrive,
    home: Mapping[str, float],
    tool_link: str | None,
    usual: Mapping[str, float] = NO_POSITIONS,
) -> DerivedJoints:
    """Derive the declaration of position-controlled joints.

    Args:
        model: Model of the robot.
        drive: Its kind.
        home: Initial positions by joint, or by pattern such as `*_knee` [rad], [m].
        tool_link: Last link of an arm; None for the one behind the most joints.
        usual: Initial positions of joints without one in `home`; zero or the middle of the limits for others.

    Raises:
        RequestRefused: The model has no such joints, or does not fit.
    """
    fingers = find_fingers(model) if drive is JointDrive.ARM else None
    if drive is JointDrive.ARM:
        tool_link = tool_link or _last_link(model, fingers)
        if tool_link not in model.frames:
            raise xml.invalid(f"unknown `tool_link` {tool_link!r}; the model has {name_list(model.frames)}")
        moved = [joint for joint in reversed(tuple(model.ancestors(tool_link))) if joint.is_movable]
    else:
        able = (joint for joint in model.joints.values() if joint.turns or (joint.slides and joint.is_limited))
        moved = [joint for joint in able if joint.mimic is None]
    _check(moved, drive)
    positions = _home(moved, home, usual)
    carries_body = drive is JointDrive.JOINTS
    efforts = {joint.name: effort_of(model, joint, carries_body=carries_body) for joint in moved}
    joints = tuple(declare_motor(model, joint, positions[joint.name], efforts[joint.name]) for joint in moved)
    arm = ArmDeclaration(tool_link=tool_link, joints=joints, gripper=declare_gripper(fingers))
    return DerivedJoints(arm, tuple(moved), efforts)


def _check(moved: Sequence[ModelJoint], drive: JointDrive) -> None:
    if not moved:
        raise xml.invalid(f"found no joints that move for `drive: {drive}`; expected one or more")
    other = next((joint for joint in moved if not joint.turns and not joint.slides), None)
    if other is not None:
        raise xml.invalid(
            f"joint {other.name!r} of the arm has type {other.kind!r}; expected 'revolute', 'continuous' or "
            "'prismatic'. Name an earlier link as `arm: {tool_link: ...}`"
        )
    endless = next((joint for joint in moved if joint.slides and not joint.is_limited), None)
    if endless is not None:
        raise xml.invalid(f"missing limits of the joint {endless.name!r}, which slides; expected `<limit>` in m")


def _last_link(model: RobotModel, fingers: Fingers | None) -> str:
    """Return the link behind the most joints, and the farthest of these."""

    def rank(link: str) -> tuple[int, int]:
        above = tuple(model.ancestors(link))
        if fingers is not None and any(joint in (*fingers.joints, *fingers.followers) for joint in above):
            return (-1, 0)
        return sum(joint.is_movable for joint in above), len(above)

    return max(model.frames, key=rank)


def _home(moved: Sequence[ModelJoint], given: Mapping[str, float], usual: Mapping[str, float]) -> dict[str, float]:
    """Return the initial positions by joint [rad], [m]."""
    found = {}
    for joint in moved:
        lower, upper = limits_of(joint)
        is_inside = lower + EDGE * (upper - lower) <= 0.0 <= upper - EDGE * (upper - lower)
        found[joint.name] = 0.0 if is_inside else round((lower + upper) / 2.0, DIGITS)
        if joint.name in usual:
            found[joint.name] = min(max(usual[joint.name], lower), upper)
    return found | given_home(given, tuple(found))


def given_home(given: Mapping[str, float], joints: Sequence[str]) -> dict[str, float]:
    """Return the initial positions by joint [rad], [m] that a declaration gives by names or patterns.

    Raises:
        RequestRefused: A pattern matches none of the joints.
    """
    try:
        return positions_by_joint(given.items(), joints, "home")
    except ValueError as error:
        raise xml.invalid(str(error)) from error


def kept_joints(model: RobotModel, arm: ArmDeclaration) -> frozenset[str]:
    """Return the names of the joints that an arm moves: with motors, or since they follow such joints."""
    with_motors = {*arm.home, *arm.fingers}
    return frozenset(with_motors | {joint.name for joint in model.followers(with_motors)})


def hold_others(root: Any, kept: frozenset[str]) -> tuple[str, ...]:
    """Hold the joints of a URDF that are not kept; return notes on them."""
    held = []
    for element in root.findall("joint"):
        name = str(element.get("name"))
        if name not in kept and element.get("type") != "fixed":
            hold_joint(element)
            held.append(name)
    return (f"without a motor, so held at 0: {name_list(held)}",) if held else ()


def complete_limits(root: Any, derived: DerivedJoints) -> tuple[str, ...]:
    """Add all limits of moved joints to a URDF; return notes on missing ones."""
    moved, notes = derived.moved, []
    names = {joint.name: joint for joint in moved}
    for element in root.findall("joint"):
        joint = names.get(str(element.get("name")))
        if joint is not None:
            _complete_limits(element, joint, derived.efforts[joint.name])
    slow = [joint.name for joint in moved if math.isinf(joint.velocity)]
    if slow:
        sliding = f" or {SPEED[True]:g} m/s" if any(joint.slides for joint in moved) else ""
        notes.append(f"without a velocity limit, so {SPEED[False]:g} rad/s{sliding}: {name_list(slow)}")
    weak = [joint.name for joint in moved if math.isinf(joint.effort)]
    if weak:
        notes.append(f"without an effort limit, so by weight: {name_list(weak)}")
    return tuple(notes)


def _without_world(root: Any, model: RobotModel) -> str:
    """Remove a root link that stands for the world, which engines have themselves; return the name of the root."""
    below = [joint for joint in model.joints.values() if joint.parent == model.root]
    if model.root != WORLD or model.solids[WORLD] or len(below) != 1 or below[0].is_movable:
        return model.root
    child = below[0].child
    if math.hypot(*model.frames[child][0]) > 0.0 or model.frames[child][1] != IDENTITY:
        return model.root
    for element in list(root):
        if element.get("name") in (WORLD, below[0].name):
            root.remove(element)
    return child


def _complete_limits(element: Any, joint: ModelJoint, effort: float) -> None:
    lower, upper = limits_of(joint)
    if joint.turns:
        element.set("type", "revolute")
    limit = element.find("limit")
    if limit is None:
        limit = SubElement(element, "limit")
    values = {"lower": lower, "upper": upper, "effort": effort, "velocity": speed_of(joint)}
    limit.attrib |= {key: repr(value) for key, value in values.items()}


def _lowest(model: RobotModel) -> float:
    """Return the height of the lowest solid in the frame of the root [m]."""
    origin = BodyState((0.0, 0.0, 0.0))
    return min(lowest_of(part, origin) for parts in model.solids.values() for part in parts)
