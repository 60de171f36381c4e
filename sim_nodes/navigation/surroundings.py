"""Obstacles around a robot in the frame of its base, and the way that is free among them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from seoro.deferred import dataclass
from sim_nodes.geometry import Array, Pose2
from sim_nodes.navigation.arcs import Points, solid_points
from sim_nodes.navigation.contracts import ControlInput
from sim_nodes.navigation.cover import Cover
from sim_nodes.navigation.maps import NavigationMap

SLACK = 1e-4  # [m] by which a gap may shrink
MAP_SLACK = 0.06  # [m] that the map may be wrong about, by errors of the localisation


@dataclass(frozen=True)
class Surroundings:
    """Points of the scan and remembered ones, and the map.

    Attributes:
        x: Points in the frame of the base [m], shape (n,).
        y: See `x`.
        pose: Localised pose in `map`.
        known: The map.
    """

    x: Array
    y: Array
    pose: Pose2
    known: NavigationMap

    @classmethod
    def seen(cls, now: ControlInput, reach: float, known: NavigationMap) -> Surroundings:
        """Return the surroundings up to a distance of the base [m]."""
        around = points_around([now], reach)
        return cls(around.x, around.y, now.pose, known)

    def count_free(self, cover: Cover, poses: Array) -> int:
        """Return the number of poses before the first one where the robot touches something.

        A robot that is too close to something already may go on, unless that brings it closer.

        Args:
            cover: Cover of the robot.
            poses: Poses (x, y, yaw) in `map`, in the order in which the robot takes them, shape (n, 3).
        """
        here = np.array(self.pose)
        around = np.vstack([here, poses])
        grid, distance = self.known.grid, self.known.distance
        on_map = cover.gaps(grid, distance, around)
        blocked = on_map[1:] < min(on_map[0], 0.0) - MAP_SLACK
        if len(self.x):
            gaps = cover.gaps_to(self.x, self.y, _in_base(around, self.pose))
            blocked |= (gaps[1:] < np.minimum(gaps[0], 0.0) - SLACK).any(axis=1)
        return int(blocked.argmax()) if blocked.any() else len(poses)


def points_around(inputs: Sequence[ControlInput], reach: float) -> Points:
    """Return points of scans up to a distance [m], and remembered ones, for some robots of a kind."""
    seen = solid_points([now.scan for now in inputs], reach)
    x, y, robot = [seen.x], [seen.y], [seen.robot]
    for number, now in enumerate(inputs):
        if len(now.remembered):
            to_base = now.pose.inverse()
            cos, sin = math.cos(to_base.yaw), math.sin(to_base.yaw)
            px, py = now.remembered.T
            x.append(to_base.x + cos * px - sin * py)
            y.append(to_base.y + sin * px + cos * py)
            robot.append(np.full(len(px), number))
    return Points(np.concatenate(x), np.concatenate(y), np.concatenate(robot)) if len(x) > 1 else seen


def _in_base(poses: Array, base: Pose2) -> Array:
    cos, sin = math.cos(base.yaw), math.sin(base.yaw)
    dx, dy = poses[:, 0] - base.x, poses[:, 1] - base.y
    return np.column_stack([cos * dx + sin * dy, cos * dy - sin * dx, poses[:, 2] - base.yaw])
