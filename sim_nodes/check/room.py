"""The room in which planners and controllers are checked, and paths through it."""

from __future__ import annotations

import math

import numpy as np

from sim_nodes.geometry import Pose2, lengths_along
from sim_nodes.navigation.contracts import Path
from sim_nodes.navigation.maps import build_map
from sim_nodes.physics import Wall
from sim_nodes.robots.declaration import MobileDeclaration

EXTENT = (-3.0, -3.0, 3.0, 3.0)  # [m]
ROOM = build_map(EXTENT, (Wall("wall", 0.0, -0.5, math.pi / 2, 5.0, 0.1, 0.5),))
CLOSED_ROOM = build_map(EXTENT, (Wall("wall", 0.0, 0.0, math.pi / 2, 7.0, 0.1, 0.5),))
START, GOAL = Pose2(-1.0, 1.0, 0.0), Pose2(1.0, -2.0, 0.0)
GOALS = (GOAL, Pose2(1.73, 2.21, 1.0), Pose2(-2.4, -1.9, 0.0), START)
ALONG = Pose2(-1.0, 1.5, math.pi / 2)  # on the path, along it
AT_WALL = Pose2(-0.15, 0.0, 0.0)  # closer to the wall than the clearance


def path_for(base: MobileDeclaration) -> Path:
    """Return a path with a curve, for a car one that it can follow; others start at `START` and end at `GOAL`."""
    if base.drive.min_turning_radius:
        return _curve(1.5 * base.drive.min_turning_radius)
    corners = np.array([START[:2], (-1.0, 2.4), (1.0, 2.4), GOAL[:2]])
    lengths = lengths_along(corners)
    along = np.linspace(0.0, lengths[-1], 200)
    return Path(np.column_stack([np.interp(along, lengths, corners[:, axis]) for axis in (0, 1)]))


def start_of(path: Path) -> Pose2:
    """Return the pose at the start of a path."""
    return START if path.headings is None else Pose2(*path.poses[0].tolist())


def _curve(radius: float) -> Path:
    """Return a quarter of a circle [m], and a straight line through `ALONG`."""
    angles, line = np.linspace(0.0, math.pi / 2, 60), np.linspace(-0.5, 2.0, 60)[1:]
    arc = np.column_stack([radius * (np.sin(angles) - 1.0) + ALONG.x, -0.5 + radius * (-np.cos(angles))])
    straight = np.column_stack([np.full(len(line), ALONG.x), line])
    return Path(np.vstack([arc, straight]), np.append(angles, np.full(len(line), ALONG.yaw)))
