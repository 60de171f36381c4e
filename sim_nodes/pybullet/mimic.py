"""Joints that follow others (`<mimic>` of URDF), as gears: Bullet's loader ignores the element."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any
from xml.etree.ElementTree import Element

import pybullet

JOINT_NAME, PARENT_BODY = 1, 0  # fields of the results of getJointInfo and getConstraintInfo
FORCE, ERROR_REDUCTION = 1000.0, 0.2  # of a gear [N], [N m]
NOWHERE = [0, 0, 0]
NO_POSITIONS: Mapping[str, float] = MappingProxyType({})


def couple_mimics(
    bullet: Any, body: int, urdf: Element, leaders: Mapping[str, float] = NO_POSITIONS, without: Sequence[str] = ()
) -> None:
    """Let joints follow others by their multiplier and offset; both joints push each other.

    Args:
        bullet: The Bullet client.
        body: Number of a body that was loaded.
        urdf: Its URDF; followers of unknown joints move freely.
        leaders: Initial positions of joints that are not at zero [rad], [m].
        without: Followers that are left out.
    """
    numbers = {
        bullet.getJointInfo(body, index)[JOINT_NAME].decode(): index for index in range(bullet.getNumJoints(body))
    }
    for joint in urdf.findall("joint"):
        mimic = joint.find("mimic")
        if mimic is None or mimic.get("joint") not in numbers or joint.get("name") in without:
            continue
        follower, leader = numbers[joint.get("name", "")], numbers[mimic.get("joint", "")]
        offset, factor = float(mimic.get("offset", "0")), float(mimic.get("multiplier", "1"))
        bullet.resetJointState(body, follower, offset + factor * leaders.get(mimic.get("joint", ""), 0.0))
        gear = bullet.createConstraint(
            body, follower, body, leader, pybullet.JOINT_GEAR, [1, 0, 0], NOWHERE, NOWHERE
        )
        bullet.changeConstraint(
            gear,
            gearRatio=-factor,
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
