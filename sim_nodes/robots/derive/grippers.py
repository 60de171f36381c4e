"""Grippers derived from a model: two fingers that slide on the same link."""

from __future__ import annotations

import math
from collections.abc import Sequence

from sim_nodes.robots.declaration import GripperDeclaration
from sim_nodes.robots.derive.model import ModelJoint, RobotModel
from sim_nodes.robots.derive.motors import DIGITS

FINGER_SPEED = 0.1  # [m/s] of the opening
FINGER_FORCES = (5.0, 100.0)  # [N] least, and greatest that still holds light things without rattling


def find_fingers(model: RobotModel) -> tuple[ModelJoint, ...]:
    """Return the joints of two fingers that slide on the same link, from 0 to the same limit; empty without."""
    sliding = [joint for joint in model.joints.values() if joint.kind == "prismatic" and joint.upper > 0.0]
    for first in reversed(sliding):
        for other in sliding:
            if other is not first and other.parent == first.parent and math.isclose(other.upper, first.upper):
                return (other, first)
    return ()


def declare_gripper(fingers: Sequence[ModelJoint]) -> GripperDeclaration | None:
    """Declare the gripper of two fingers; None without fingers."""
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
