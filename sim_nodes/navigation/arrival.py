"""Arrival of a robot at a pose."""

from __future__ import annotations

import math

from sim_nodes.geometry import Pose2
from sim_nodes.navigation.contracts import Path
from sim_nodes.robots.declaration import MobileDeclaration

PASSED = 2.5  # times the tolerance within which a robot that has driven past the goal has arrived
ASIDE = 4.0  # times the tolerance to the side within which a robot has arrived that cannot move sideways
ALIGN_GAIN = 1.5  # [1/s]
ALIGN_RATES = (0.3, 1.2)  # minimum and maximum [rad/s]


def align_rate(error: float) -> float:
    """Return the rate of a turn in place to the heading of a pose, by the remaining angle [rad], [rad/s]."""
    low, high = ALIGN_RATES
    return math.copysign(max(low, min(high, ALIGN_GAIN * abs(error))), error)


def has_arrived(
    declaration: MobileDeclaration, pose: Pose2, target: Pose2, path: Path | None, *, aligns: bool, follows: bool
) -> bool:
    """Whether a robot has arrived at a pose where it stops.

    Args:
        declaration: Declaration of the robot.
        pose: Its localised pose.
        target: The pose where it stops.
        path: Its path, if any.
        aligns: Whether it turns to the heading of the pose afterwards, in place; others arrive with that heading.
        follows: Whether the controller follows the poses of the path up to its end.
    """
    p = declaration.navigation
    tolerance = p.xy_goal_tolerance
    offset = pose.inverse().compose(target)
    distance = math.hypot(offset.x, offset.y)
    if aligns and (path is None or not follows):
        return distance < tolerance or (offset.x < 0.0 and distance < PASSED * tolerance)
    if path is None or (not aligns and abs(offset.yaw) >= p.yaw_goal_tolerance):
        return False
    if declaration.drive.max_lateral_speed:
        return distance < tolerance
    way = int(path.ways[-1]) if len(path.ways) else 0
    if way == 0:  # the path ends with a turn, which started at the place of the goal
        return distance < PASSED * tolerance
    return -tolerance < -way * offset.x < PASSED * tolerance and abs(offset.y) < ASIDE * tolerance
