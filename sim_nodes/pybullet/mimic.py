"""Joints that follow others (`<mimic>` of URDF), as gears: Bullet's loader ignores the element."""

from __future__ import annotations

from typing import Any
from xml.etree.ElementTree import Element

import pybullet

JOINT_NAME, PARENT_BODY = 1, 0  # fields of the results of getJointInfo and getConstraintInfo
FORCE, ERROR_REDUCTION = 1000.0, 0.2  # of a gear [N], [N m]
NOWHERE = [0, 0, 0]


def couple_mimics(bullet: Any, body: int, urdf: Element) -> None:
    """Let joints follow others by their multiplier and offset; both joints push each other.

    Args:
        bullet: The Bullet client.
        body: Number of a body that was loaded.
        urdf: Its URDF; followers of unknown joints move freely.
    """
    numbers = {
        bullet.getJointInfo(body, index)[JOINT_NAME].decode(): index for index in range(bullet.getNumJoints(body))
    }
    for joint in urdf.findall("joint"):
        mimic = joint.find("mimic")
        if mimic is None or mimic.get("joint") not in numbers:
            continue
        follower, leader = numbers[joint.get("name", "")], numbers[mimic.get("joint", "")]
        offset = float(mimic.get("offset", "0"))
        bullet.resetJointState(body, follower, offset)
        gear = bullet.createConstraint(
            body, follower, body, leader, pybullet.JOINT_GEAR, [1, 0, 0], NOWHERE, NOWHERE
        )
        bullet.changeConstraint(
            gear,
            gearRatio=-float(mimic.get("multiplier", "1")),
            relativePositionTarget=offset,
            maxForce=FORCE,
            erp=ERROR_REDUCTION,
        )


def remove_gears(bullet: Any, body: int) -> None:
    """Remove the gears of a body, before the body is removed."""
    gears = [bullet.getConstraintUniqueId(index) for index in range(bullet.getNumConstraints())]
    for gear in gears:
        if bullet.getConstraintInfo(gear)[PARENT_BODY] == body:
            bullet.removeConstraint(gear)
