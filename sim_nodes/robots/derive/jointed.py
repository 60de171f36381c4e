"""Declarations of arms and of bodies that move by their joints, derived from their models.

The motor of a joint with effort limit F [N m] has its full effort at an error of `FULL_EFFORT`: its stiffness is
k = F / FULL_EFFORT. The inertia I about the joint is that of the moved links, as points at their centres of mass.
All joints are at zero for it. The armature a keeps the natural frequency sqrt(k / (I + a)) at `FREQUENCY` or less,
at which steps of 5 ms are stable. Damping is critical: 2 sqrt(k (I + a)).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from fnmatch import fnmatchcase
from typing import Any
from xml.etree.ElementTree import SubElement, tostring

import numpy as np
from defusedxml import ElementTree

from seoro.bridges.wire.refusal import name_list
from sim_nodes.extents import lowest_of
from sim_nodes.geometry import Array, multiply, rotated, vector
from sim_nodes.models import xml_reading as xml
from sim_nodes.physics import IDENTITY, BodyState
from sim_nodes.robots.declaration import ArmDeclaration, GripperDeclaration, JointDeclaration
from sim_nodes.robots.derive.model import ModelJoint, RobotModel
from sim_nodes.robots.derive.rewriting import hold_joint

FULL_EFFORT = 0.05  # [rad]
FREQUENCY = 100.0  # [rad/s]
LEAST_ARMATURE = 1e-3  # [kg m^2]
ACCELERATIONS = (1.0, 10.0)  # [rad/s^2]
SPEED = 2.0  # [rad/s] of joints without a limit
TURN = 2.0 * math.pi  # [rad] limit of arm joints that turn freely
GRAVITY = 9.81  # [m/s^2]
EDGE = 0.05  # share of the range of a joint; home is the middle if zero is nearer to a limit
DIGITS = 6
WORLD = "world"  # name of a root link that stands for the world, by the convention of ROS
FINGER_SPEED = 0.1  # [m/s] of the opening
FINGER_FORCES = (5.0, 100.0)  # [N] least, and greatest that still holds light things without rattling


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


def derive_jointed(
    model: RobotModel, drive: JointDrive, home: Mapping[str, float], tool_link: str | None
) -> JointedRobot:
    """Derive the declaration of position-controlled joints.

    Args:
        model: Model of the robot.
        drive: Its kind.
        home: Initial positions by joint, or by pattern such as `*_knee` [rad]; zero or the middle of the limits
            for others.
        tool_link: Last link of an arm; None for the one behind the most joints.

    Raises:
        RequestRefused: The model has no such joints, or does not fit.
    """
    fingers = _fingers(model) if drive is JointDrive.ARM else ()
    if drive is JointDrive.ARM:
        tool_link = tool_link or _last_link(model, fingers)
        if tool_link not in model.frames:
            raise xml.invalid(f"unknown `tool_link` {tool_link!r}; the model has {name_list(model.frames)}")
        moved = [joint for joint in reversed(tuple(model.ancestors(tool_link))) if joint.is_movable]
    else:
        moved = [joint for joint in model.joints.values() if joint.kind in ("revolute", "continuous")]
    _check(moved, drive)
    positions = _home(moved, home)
    efforts = {joint.name: _effort(model, joint, drive) for joint in moved}
    root: Any = ElementTree.fromstring(model.urdf.text)
    notes = _complete(root, moved, fingers, efforts)
    base_link = _without_world(root, model)
    joints = tuple(
        _joint(joint.name, positions[joint.name], efforts[joint.name], _inertia(model, joint)) for joint in moved
    )
    height = -_lowest(model, positions) if drive is JointDrive.JOINTS else 0.0
    arm = ArmDeclaration(tool_link=tool_link, joints=joints, gripper=_gripper(model, fingers))
    text = tostring(root, encoding="unicode").replace("><", ">\n<")
    return JointedRobot(text, base_link, arm, round(max(0.0, height), DIGITS), notes)


def _check(moved: Sequence[ModelJoint], drive: JointDrive) -> None:
    if not moved:
        raise xml.invalid(f"found no joints that move for `drive: {drive}`; expected one or more")
    other = next((joint for joint in moved if joint.kind not in ("revolute", "continuous")), None)
    if other is not None:
        raise xml.invalid(
            f"joint {other.name!r} of the arm has type {other.kind!r}; expected 'revolute' or 'continuous'. "
            "Name an earlier link as `arm: {tool_link: ...}`"
        )


def _fingers(model: RobotModel) -> tuple[ModelJoint, ...]:
    """Return the joints of two fingers that slide on the same link, from 0 to the same limit; empty without."""
    sliding = [joint for joint in model.joints.values() if joint.kind == "prismatic" and joint.upper > 0.0]
    for first in reversed(sliding):
        for other in sliding:
            if other is not first and other.parent == first.parent and math.isclose(other.upper, first.upper):
                return (other, first)
    return ()


def _last_link(model: RobotModel, fingers: Sequence[ModelJoint]) -> str:
    """Return the link behind the most joints, and the farthest of these."""

    def rank(link: str) -> tuple[int, int]:
        above = tuple(model.ancestors(link))
        if any(joint in fingers for joint in above):
            return (-1, 0)
        return sum(joint.is_movable for joint in above), len(above)

    return max(model.frames, key=rank)


def _home(moved: Sequence[ModelJoint], given: Mapping[str, float]) -> dict[str, float]:
    """Return the initial positions by joint [rad]."""
    unused = set(given)
    found = {}
    for joint in moved:
        lower, upper = _limits(joint)
        is_inside = lower + EDGE * (upper - lower) <= 0.0 <= upper - EDGE * (upper - lower)
        found[joint.name] = 0.0 if is_inside else round((lower + upper) / 2.0, DIGITS)
        for pattern, value in given.items():
            if fnmatchcase(joint.name, pattern):
                found[joint.name] = value
                unused.discard(pattern)
    if unused:
        names = name_list(joint.name for joint in moved)
        raise xml.invalid(f"`home` names the unknown joint {min(unused)!r}; expected names or patterns of {names}")
    return found


def _limits(joint: ModelJoint) -> tuple[float, float]:
    return (-TURN, TURN) if math.isinf(joint.lower) or math.isinf(joint.upper) else (joint.lower, joint.upper)


def _moved_links(model: RobotModel, joint: ModelJoint) -> list[str]:
    return [link for link in model.frames if joint in model.ancestors(link)]


def _inertia(model: RobotModel, joint: ModelJoint) -> float:
    """Return the inertia about a joint of the links that it moves, as points with all joints at zero [kg m^2]."""
    origin, total = np.array(model.frames[joint.child][0]), 0.0
    for link in _moved_links(model, joint):
        arm = np.cross(joint.axis, np.array(model.centres[link]) - origin)
        total += model.masses[link] * float(arm @ arm)
    return total


def _effort(model: RobotModel, joint: ModelJoint, drive: JointDrive) -> float:
    """Return the effort limit [N m]: that of the model, or twice what the weight of its links needs."""
    if math.isfinite(joint.effort):
        return joint.effort
    origin = np.array(model.frames[joint.child][0])
    links = _moved_links(model, joint)
    arms = {link: float(np.linalg.norm(np.array(model.centres[link]) - origin)) for link in links}
    if drive is JointDrive.JOINTS:  # a leg carries the body
        return max(1.0, round(GRAVITY * model.mass * max(arms.values()), DIGITS))
    return max(1.0, round(2.0 * GRAVITY * sum(model.masses[link] * arms[link] for link in links), DIGITS))


def _joint(name: str, home: float, effort: float, inertia: float) -> JointDeclaration:
    stiffness = effort / FULL_EFFORT
    armature = max(LEAST_ARMATURE, stiffness / FREQUENCY**2 - inertia)
    low, high = ACCELERATIONS
    return JointDeclaration(
        name=name,
        home=home,
        max_acceleration=round(min(high, max(low, effort / (2.0 * (inertia + armature)))), DIGITS),
        stiffness=round(stiffness, DIGITS),
        damping=round(2.0 * math.sqrt(stiffness * (inertia + armature)), DIGITS),
        armature=round(armature, DIGITS),
    )


def _gripper(model: RobotModel, fingers: Sequence[ModelJoint]) -> GripperDeclaration | None:
    if not fingers:
        return None
    first, second = fingers
    least, most = FINGER_FORCES
    force = min(most, *(joint.effort for joint in fingers))
    return GripperDeclaration(
        joints=(first.name, second.name),
        links=(first.child, second.child),
        stroke=round(2.0 * first.upper, DIGITS),
        max_speed=min(FINGER_SPEED, *(2.0 * joint.velocity for joint in fingers)),
        min_force=min(least, force / 2.0),
        max_force=force,
        usual_force=round(max(min(least, force / 2.0), force / 2.0), DIGITS),
        stiffness=20000.0,
        damping=400.0,
        armature=1.0,
        friction=1.0,
        torsional_friction=0.05,
    )


def _complete(
    root: Any, moved: Sequence[ModelJoint], fingers: Sequence[ModelJoint], efforts: Mapping[str, float]
) -> tuple[str, ...]:
    """Add all limits of the moved joints to a URDF, and hold other joints; return notes on the changes."""
    names, notes = {joint.name: joint for joint in moved}, []
    kept = {joint.name for joint in fingers}
    held = []
    for element in root.findall("joint"):
        name = str(element.get("name"))
        if name in names:
            _complete_limits(element, names[name], efforts[name])
        elif name not in kept and element.get("type") != "fixed":
            hold_joint(element)
            held.append(name)
    if held:
        notes.append(f"without a motor, so held at 0: {name_list(held)}")
    slow = [joint.name for joint in moved if math.isinf(joint.velocity)]
    if slow:
        notes.append(f"without a velocity limit, so {SPEED:g} rad/s: {name_list(slow)}")
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
    lower, upper = _limits(joint)
    element.set("type", "revolute")
    limit = element.find("limit")
    if limit is None:
        limit = SubElement(element, "limit")
    speed = SPEED if math.isinf(joint.velocity) else joint.velocity
    values = {"lower": lower, "upper": upper, "effort": effort, "velocity": speed}
    limit.attrib |= {key: repr(value) for key, value in values.items()}


def _lowest(model: RobotModel, positions: Mapping[str, float]) -> float:
    """Return the height of the lowest solid with the joints at some positions, in the frame of the root [m]."""
    return min(
        lowest_of(part, _motion(model, link, positions)) for link, parts in model.solids.items() for part in parts
    )


def _motion(model: RobotModel, link: str, positions: Mapping[str, float]) -> BodyState:
    """Return how joints move a link from its place with all joints at zero, by the product of exponentials."""
    place, turn = np.zeros(3), IDENTITY
    for joint in model.ancestors(link):
        half = positions.get(joint.name, 0.0) / 2.0
        x, y, z = (math.sin(half) * value for value in joint.axis)
        rotation = (math.cos(half), x, y, z)
        origin: Array = np.array(model.frames[joint.child][0])
        place = origin + np.array(rotated(rotation, vector(place - origin)))
        turn = multiply(rotation, turn)
    return BodyState(vector(place), turn)
