"""The controller `arcs`: it follows a path along the best of some arcs that are free of obstacles.

The first arcs lead to points of the path, as in pure pursuit (Coulter 1992). A fan of others leads around
obstacles. Each arc ends where the robot would come too close to a point of the scan, so that errors of the
localisation do not matter there. The arc whose end is nearest to the point ahead on the path is best. The robot
turns in place if that point is not ahead, and drives no faster than it can stop before the end of its arc.
"""

from __future__ import annotations

import math

import numpy as np

from sim_nodes.geometry import Array, Pose2
from sim_nodes.navigation.arcs import arc_points, free_lengths
from sim_nodes.navigation.braking import STOP_MARGIN, Braking, turn_rate
from sim_nodes.navigation.contracts import ControlInput, Controller, Path, Setup, UnsuitableRobot
from sim_nodes.navigation.surroundings import MAP_SLACK, points_around
from sim_nodes.robots.kinematics import Velocity

FAN = np.array([0.0, 0.4, 0.9, 1.6, 2.5, 3.6, 5.0, 8.0])  # curvatures [1/m], to both sides
NEARER = (0.6, 0.35)  # further points of the path that arcs lead to, relative to the look-ahead
STEADINESS = 0.004  # [m / (1/m)]; cost of a change of curvature
PROGRESS = 0.01  # [m] that an arc must lead towards the point ahead
MOST_NOISE = 0.02  # [m] of a lidar that the robot keeps away beyond its clearance
OPEN = 0.02  # [m]; a shorter arc is blocked
FACING = 0.2  # [rad] to the point ahead at which turning in place ends
SAMPLES = 5  # points of an arc that are looked up on the map
DONE = 1e-3  # [m]


class ArcController(Controller):
    """The default controller of robots that turn in place, along paths without headings.

    It keeps a circle free, as planners do without headings, also around a polygon.
    """

    STATE = ("_is_turning", "_curvature")
    FOLLOWS_HEADINGS = False

    def __init__(self, setup: Setup) -> None:
        setup.refuse_parameters("controller `arcs`")
        declared = setup.declaration
        if declared.drive.min_turning_radius:
            raise UnsuitableRobot("`arcs` turns in place, which the drive cannot; expected `pursuit`")
        self._drive = declared.drive
        self._braking = Braking(declared.drive)
        self._parameters = p = declared.navigation
        self._known = setup.known
        self._clearance = declared.clearance
        noise = 0.0 if declared.lidar is None else min(declared.lidar.noise, MOST_NOISE)
        self._limit = declared.clearance + noise  # noise lets obstacles appear farther than they are
        self._top_speed = min(self._drive.max_speed, p.desired_linear_vel or math.inf)
        self._turn_rate = min(p.rotate_to_heading_angular_vel, self._drive.max_turn_rate)
        self._fan = np.concatenate([-FAN[:0:-1], FAN])
        self._reach = p.lookahead_dist + self._clearance + self._braking.room(self._top_speed)
        self.begin()

    def begin(self) -> None:
        """See `Controller.begin`."""
        self._is_turning = False
        self._curvature = 0.0

    def follow(self, path: Path, now: ControlInput, *, stops: bool) -> Velocity | None:
        """See `Controller.follow`."""
        to_base = now.pose.inverse()
        x, y, remaining = self._points_ahead(path, now.pose, to_base)
        distance = math.hypot(x[0], y[0])
        bearing = math.atan2(y[0], x[0]) if distance > DONE else 0.0
        if self._must_turn(bearing, distance):
            return self._turn(bearing)
        towards = 2.0 * y / np.maximum(x * x + y * y, DONE)
        curvatures = np.concatenate([towards, self._fan])
        free = self._free_lengths(curvatures, now)
        reached = np.minimum(free, min(distance, self._parameters.lookahead_dist))
        end_x, end_y = arc_points(curvatures, reached)
        missing = np.hypot(end_x - x[0], end_y - y[0])
        cost = missing + STEADINESS * np.abs(curvatures - self._curvature)
        cost[(reached < min(OPEN, distance / 2.0)) | (missing > distance - min(PROGRESS, distance / 2.0))] = np.inf
        best = int(cost.argmin())
        if not math.isfinite(cost[best]):
            return self._turn(bearing) if abs(bearing) > FACING else None
        self._curvature = float(curvatures[best])
        return self._drive_along(self._curvature, float(free[best]), remaining if stops else math.inf)

    def _points_ahead(self, path: Path, pose: Pose2, to_base: Pose2) -> tuple[Array, Array, float]:
        """Return points ahead on the path in the frame of the base, farthest first, and the rest of it [m]."""
        index = path.nearest(pose.x, pose.y)
        to_go = path.to_go[index]
        ahead = self._parameters.lookahead_dist * np.array((1.0, *NEARER))
        # `to_go` decreases along the path.
        found = np.searchsorted(-path.to_go, ahead - to_go).clip(index, len(path.points) - 1)
        cos, sin = math.cos(to_base.yaw), math.sin(to_base.yaw)
        px, py = path.points[found].T
        return to_base.x + cos * px - sin * py, to_base.y + sin * px + cos * py, float(to_go)

    def _must_turn(self, bearing: float, distance: float) -> bool:
        limit = FACING if self._is_turning else self._parameters.rotate_to_heading_min_angle
        self._is_turning = abs(bearing) > limit and distance > DONE
        return self._is_turning

    def _turn(self, bearing: float) -> Velocity:
        """Turn in place towards a bearing."""
        self._curvature = 0.0
        return Velocity(0.0, math.copysign(turn_rate(bearing, self._turn_rate), bearing))

    def _free_lengths(self, curvatures: Array, now: ControlInput) -> Array:
        """Return the free lengths of arcs among points of the scan, remembered ones and walls of the map [m]."""
        x, y = points_around(now, self._reach)
        most = self._parameters.lookahead_dist + self._braking.room(self._top_speed)
        free = free_lengths(curvatures, x, y, self._limit, most)
        return np.minimum(free, self._free_on_map(curvatures, now.pose, most))

    def _free_on_map(self, curvatures: Array, pose: Pose2, most: float) -> Array:
        """Return the lengths of arcs before walls of the map [m], for what the lidar does not see."""
        grid, distance = self._known.grid, self._known.distance
        here = float(distance[grid.cell(pose.x, pose.y)])
        least = min(self._clearance, here) - MAP_SLACK
        if here - most - 2.0 * grid.resolution > least:
            return np.full(len(curvatures), np.inf)  # no wall is that close
        lengths = np.linspace(most / SAMPLES, most, SAMPLES)
        x, y = arc_points(curvatures[:, None], lengths)
        cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
        room = distance[grid.cells(pose.x + cos * x - sin * y, pose.y + sin * x + cos * y)]
        blocked = room < least
        first = np.where(blocked.any(axis=1), blocked.argmax(axis=1), SAMPLES)
        free: Array = np.where(first == SAMPLES, np.inf, first * (most / SAMPLES))
        return free

    def _drive_along(self, curvature: float, free: float, remaining: float) -> Velocity:
        speed = min(
            self._top_speed,
            self._braking.speed(free - STOP_MARGIN),
            self._turn_rate / max(abs(curvature), 1e-6),
            self._parameters.min_approach_linear_velocity + remaining,
        )
        return Velocity(speed, speed * curvature)
