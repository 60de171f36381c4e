"""Grippers derived from a model: two fingers on the same link, which slide or turn.

If fingers turn, the second joint follows the first, and further links may follow as well. The opening is the gap
between the last links of both sides, along the line between their joints.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from seoro.deferred import dataclass
from sim_nodes.geometry import Array
from sim_nodes.robots.declaration import FingerMotion, GripperDeclaration
from sim_nodes.robots.derive.model import ModelJoint, RobotModel
from sim_nodes.robots.derive.motors import DIGITS
from sim_nodes.robots.derive.wheels import farthest

FINGER_SPEED = 0.1  # [m/s] of the opening
FINGER_FORCES = (5.0, 100.0)  # [N] least, and greatest that still holds light things without rattling
ROWS = 9  # of the table of fingers that turn
LEAST_STROKE = 0.01  # [m]
STIFF = 20000.0  # [N/m] of a finger


@dataclass(frozen=True)
class Fingers:
    """Two fingers of a model.

    Attributes:
        joints: Their joints with motors.
        links: Links that grip.
        followers: Further joints, which follow.
        motion: Openings of fingers that turn.
    """

    joints: tuple[ModelJoint, ModelJoint]
    links: tuple[str, str]
    followers: tuple[ModelJoint, ...] = ()
    motion: FingerMotion | None = None

    @property
    def stroke(self) -> float:
        """Maximum opening [m]."""
        return 2.0 * self.joints[0].upper if self.motion is None else max(self.motion.openings)


def find_fingers(model: RobotModel) -> Fingers | None:
    """Return the fingers of a gripper, if it has two that slide or turn on the same link."""
    sliding = [joint for joint in model.joints.values() if joint.slides and joint.upper > 0.0]
    for first in reversed(sliding):
        for other in sliding:
            if other is not first and other.parent == first.parent and math.isclose(other.upper, first.upper):
                return Fingers((other, first), (other.child, first.child))
    pairs = [
        (leader, follower)
        for leader in model.joints.values()
        for follower in model.followers([leader.name])
        if leader.turns and leader.is_limited and follower.parent == leader.parent and follower.mimic is not None
        if follower.mimic[1:] == (1.0, 0.0)
    ]
    pairs.sort(
        key=lambda pair: -float(np.linalg.norm(_apart(model, *pair)))
    )  # links of one side are close together
    return next((found for pair in pairs if (found := _turning(model, pair)) is not None), None)


def _turning(model: RobotModel, joints: tuple[ModelJoint, ModelJoint]) -> Fingers | None:
    """Return fingers that turn with a pair of joints; None if they do not open and close."""
    leader, second = joints
    apart = _apart(model, leader, second)
    followers = tuple(each for each in model.followers([leader.name, second.name]) if each is not second)
    middle = np.add(model.frames[second.child][0], model.frames[leader.child][0]) / 2.0
    sides = [float(np.subtract(model.frames[each.child][0], middle) @ apart) for each in followers]
    first_side, second_side = (
        [each for each, side in zip(followers, sides, strict=True) if sign * side > 0.0] for sign in (-1.0, 1.0)
    )
    links = (_last_solid(model, (leader, *first_side)), _last_solid(model, (second, *second_side)))
    if None in links:
        return None
    first_link, second_link = map(str, links)
    positions = np.linspace(leader.lower, leader.upper, ROWS)
    openings = []
    for position in positions.tolist():
        given = {each.name: _followed(each, position) for each in (second, *followers)}
        moved = model.at({leader.name: position, **given})
        along = apart / np.linalg.norm(apart)
        gap = -farthest(moved.solids[second_link], -along) - farthest(moved.solids[first_link], along)
        openings.append(gap)
    return _useful(joints, (first_link, second_link), followers, positions, np.array(openings))


def _apart(model: RobotModel, first: ModelJoint, second: ModelJoint) -> Array:
    """Return the vector from one joint to another, shape (3,) [m]."""
    found: Array = np.subtract(model.frames[second.child][0], model.frames[first.child][0])
    return found


def _followed(joint: ModelJoint, position: float) -> float:
    """Return the position of a joint that follows one at a position [rad]."""
    assert joint.mimic is not None, "it follows"
    _, factor, offset = joint.mimic
    return factor * position + offset


def _useful(
    joints: tuple[ModelJoint, ModelJoint],
    links: tuple[str, str],
    followers: tuple[ModelJoint, ...],
    positions: Array,
    openings: Array,
) -> Fingers | None:
    """Return fingers by their openings, from where they meet to where they are open."""
    rows = openings >= min(0.0, openings.max())
    positions, openings = positions[rows], openings[rows]
    ways = np.diff(openings)
    if len(ways) == 0 or np.ptp(openings) < LEAST_STROKE or np.ptp(np.sign(ways)) or not ways.all():
        return None
    motion = FingerMotion(
        positions=tuple(np.round(positions, DIGITS).tolist()), openings=tuple(np.round(openings, DIGITS).tolist())
    )
    return Fingers(joints, links, followers, motion)


def _last_solid(model: RobotModel, joints: Sequence[ModelJoint]) -> str | None:
    """Return the solid link behind some joints with the most joints to the palm; the farthest of these."""
    solid = [link for link in model.frames if model.solids[link]]
    behind = [link for link in solid if any(each in joints for each in model.ancestors(link))]
    palm = model.frames[joints[0].parent][0]

    def rank(link: str) -> tuple[int, float]:
        reach = max(math.dist(part.position, palm) for part in model.solids[link])
        return len(tuple(model.ancestors(link))), reach

    return max(behind, key=rank, default=None)


def declare_gripper(fingers: Fingers | None) -> GripperDeclaration | None:
    """Declare the gripper of two fingers; None without fingers."""
    if fingers is None:
        return None
    first, second = fingers.joints
    lever = 1.0 if fingers.motion is None else fingers.motion.lever
    least, most = FINGER_FORCES
    force = min(most, *(joint.effort / lever for joint in fingers.joints))
    stiffness = STIFF * lever**2
    return GripperDeclaration(
        joints=(first.name, second.name),
        links=fingers.links,
        stroke=round(fingers.stroke, DIGITS),
        max_speed=min(FINGER_SPEED, *(2.0 * lever * joint.velocity for joint in fingers.joints)),
        min_force=min(least, force / 2.0),
        max_force=force,
        usual_force=round(max(min(least, force / 2.0), force / 2.0), DIGITS),
        stiffness=stiffness,
        damping=400.0 * lever**2,
        armature=lever**2,
        friction=1.0,
        torsional_friction=0.05,
        turning=fingers.motion,
    )
