"""Recoveries of a blocked robot: back up, spin, wait."""

from __future__ import annotations

import math

import numpy as np

from sim_nodes.geometry import Array, Pose2
from sim_nodes.navigation.arcs import solid_points
from sim_nodes.navigation.contracts import ControlInput
from sim_nodes.navigation.cover import Cover
from sim_nodes.navigation.maps import NavigationMap
from sim_nodes.navigation.surroundings import Surroundings
from sim_nodes.robots.declaration import MobileDeclaration
from sim_nodes.robots.kinematics import AT_REST, Velocity
from sim_nodes.robots.navigation import Recovery

SPIN_RATE = 1.0  # [rad/s]
STEP = 0.1  # [m] ahead or behind where the room is compared
DRIVE_AHEAD = np.array([(STEP / 2.0, 0.0, 0.0), (STEP, 0.0, 0.0)])  # poses that must be free to drive ...
SPIN_AHEAD = np.array([(0.0, 0.0, 0.1), (0.0, 0.0, 0.3)])  # ... and to spin


class Recoveries:
    """The recoveries of a robot.

    Args:
        known: The map.
        declaration: Declaration of the robot.
        cover: Its cover.

    Attributes:
        kinds: Kinds of recoveries, in turn: those of its parameters that its drive can make.
    """

    def __init__(self, known: NavigationMap, declaration: MobileDeclaration, cover: Cover) -> None:
        self._known = known
        self._cover = cover
        self._clearance = declaration.clearance
        self._parameters = p = declaration.navigation
        steers = declaration.drive.min_turning_radius > 0.0
        self.kinds = tuple(kind for kind in p.recoveries if not (steers and kind == "spin"))
        self._spin_rate = min(SPIN_RATE, declaration.drive.max_turn_rate)
        self._durations: dict[Recovery, float] = {
            "backup": p.backup_dist / p.backup_speed,
            "spin": p.spin_dist / self._spin_rate,
            "wait": p.wait_duration,
        }

    def duration(self, kind: Recovery) -> float:
        """Return the duration of a recovery [s]."""
        return self._durations[kind]

    def velocity(self, kind: Recovery, now: ControlInput) -> Velocity:
        """Return the velocity of a recovery."""
        match kind:
            case "backup":
                return Velocity(self._speed_of_retreat(now), 0.0)
            case "spin":
                return Velocity(0.0, self._spin_rate) if self.can_turn(now, 1.0) else AT_REST
            case "wait":
                return AT_REST

    def can_turn(self, now: ControlInput, way: float) -> bool:
        """Whether the outline is free for a turn in place, to the left if `way` is positive."""
        return self._cover.is_round or self._is_free(now, math.copysign(1.0, way) * SPIN_AHEAD)

    def _speed_of_retreat(self, now: ControlInput) -> float:
        """Return the speed [m/s] to back up, or to leave an obstacle forwards; or 0."""
        if not self._cover.is_round:
            ways = (way for way in (-1.0, 1.0) if self._is_free(now, way * DRIVE_AHEAD))
            return self._parameters.backup_speed * next(ways, 0.0)
        here, behind, ahead = (self._room(now, distance) for distance in (0.0, -STEP, STEP))
        if behind >= self._clearance or behind > here:
            return -self._parameters.backup_speed
        return self._parameters.backup_speed if here < self._clearance and ahead > here else 0.0

    def _is_free(self, now: ControlInput, motion: Array) -> bool:
        """Whether the outline is free along poses in the frame of the base, shape (n, 3)."""
        around = Surroundings.seen(now, self._cover.reach + 2.0 * STEP, self._known)
        poses = np.array([now.pose.compose(Pose2(*pose)) for pose in motion.tolist()])
        return around.count_free(self._cover, poses) == len(poses)

    def _room(self, now: ControlInput, ahead: float) -> float:
        """Return the distance to the nearest obstacle or wall from a place ahead [m]."""
        there = now.pose.compose(Pose2(ahead, 0.0, 0.0))
        grid = self._known.grid
        room = float(self._known.distance[grid.cell(there.x, there.y)])
        around = solid_points([now.scan], self._clearance + 2.0 * STEP)
        x, y = around.x, around.y
        nearest = np.hypot(x - ahead, y).min(initial=math.inf)
        hidden = np.hypot(now.remembered[:, 0] - there.x, now.remembered[:, 1] - there.y).min(initial=math.inf)
        return min(room, float(nearest), float(hidden))
