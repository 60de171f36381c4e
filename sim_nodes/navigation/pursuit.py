"""The controller `pursuit`: it follows the poses of a path, with changes of direction and turns in place.

The curvature is that of the path with linear feedback of two errors: across the path, and in heading. Both poles
are equal (K. M. Lynch and F. C. Park: Modern Robotics, 2017, section 13.3.4). The robot slows down for curves and
before each change of direction. It stops where its outline would touch a point of the scan on the path ahead.
"""

from __future__ import annotations

import math

import numpy as np

from sim_nodes.geometry import Array, Indices, Pose2, lengths_along, wrap
from sim_nodes.navigation.braking import CALM, LATENCY, SLOWEST_TURN, STOP_MARGIN, turn_rate
from sim_nodes.navigation.contracts import ControlInput, Path, Setup, UnsuitableRobot
from sim_nodes.navigation.following import LARGEST_VIEW, WINDOW, PoseController
from sim_nodes.navigation.surroundings import Surroundings
from sim_nodes.robots.kinematics import Velocity

DECAY = 0.2  # [m] in which errors decay, at rest
DECAY_TIME = 0.4  # [s] of driving that is added to it
REACHED = 0.01  # [m] before the end of a piece at which it has ended
BLUR = 0.06  # [m] to both sides over which curvatures of the path are averaged
TURNED = 0.04  # [rad] from the end of a turn at which it has ended
SWING_TIME = 0.5  # [s] in which a car steers from one side to the other; it slows down for faster changes
CREEP = 0.05  # [m/s] at the end of a piece


class PursuitController(PoseController):
    """The default controller along paths with headings, for drives that do not move sideways."""

    def __init__(self, setup: Setup) -> None:
        super().__init__(setup, "pursuit")
        if self._drive.max_lateral_speed:
            raise UnsuitableRobot(
                "`pursuit` does not move sideways, but paths of this drive do; expected `holonomic`"
            )
        radius = self._drive.min_turning_radius
        self._most = 1.0 / radius if radius else math.inf  # curvature [1/m]

    def follow(self, path: Path, now: ControlInput, *, stops: bool) -> Velocity | None:
        """See `Controller.follow`."""
        poses, ways = path.poses, path.ways
        while True:
            if self._index >= len(ways):
                return None
            way = int(ways[self._index])
            end = _end_of_piece(ways, self._index)
            if way == 0:
                ahead = poses[self._index : min(self._index + WINDOW, end) + 1, 2]
                self._index += int(np.abs(wrap(ahead - now.pose.yaw)).argmin())
                error = wrap(float(poses[min(self._index + WINDOW, end), 2]) - now.pose.yaw)
                if self._index < end or abs(error) > TURNED:
                    return self._turn(error, now)
            else:
                ahead = poses[self._index : min(self._index + WINDOW, end)]
                self._index += int(np.hypot(ahead[:, 0] - now.pose.x, ahead[:, 1] - now.pose.y).argmin())
                off = wrap(float(poses[self._index, 2]) - now.pose.yaw)
                if self._most == math.inf and abs(off) > self._parameters.rotate_to_heading_min_angle:
                    return self._turn(off, now)
                if self._remaining(poses, ways, end, now.pose) > REACHED:
                    return self._drive_along(path, way, end, now, stops=stops)
            self._index = end

    def _remaining(self, poses: Array, ways: Indices, end: int, pose: Pose2) -> float:
        """Return the way to the end of the piece [m], negative beyond it."""
        here, way = poses[self._index], int(ways[end - 1])
        beyond: float = way * (math.cos(here[2]) * (pose.x - here[0]) + math.sin(here[2]) * (pose.y - here[1]))
        steps = np.diff(poses[self._index : end + 1, :2], axis=0)
        length = float(np.hypot(steps[:, 0], steps[:, 1]).sum())
        return length - beyond

    # ------------------------------------------------------------ drive

    def _drive_along(self, path: Path, way: int, end: int, now: ControlInput, *, stops: bool) -> Velocity | None:
        poses = path.poses
        piece = poses[self._index : end + 1]
        lengths = lengths_along(piece[:, :2])
        curvatures = _curvatures(piece, lengths, way)
        view = min(len(piece), LARGEST_VIEW)
        around = Surroundings.seen(now, self._reach, self._known)
        count = around.count_free(self._cover, piece[1:view])
        free = float(lengths[count]) if count < view - 1 else math.inf
        remaining = self._remaining(poses, path.ways, end, now.pose)
        is_last = end == len(path.ways)
        final = CREEP if stops or not is_last else self._top_speed
        if is_last and stops:
            final = self._parameters.min_approach_linear_velocity
        speed = min(
            self._top_speed,
            self._braking.speed(free - STOP_MARGIN) if math.isfinite(free) else math.inf,
            final + self._braking.calm_speed(remaining - REACHED),
            self._speed_for(curvatures, lengths),
        )
        if speed <= 0.0:
            return None
        curvature = self._corrected(piece, curvatures, lengths, way, now)
        speed = min(speed, self._turn_rate / max(abs(curvature), 1e-6))
        return Velocity(way * speed, way * speed * curvature)

    def _corrected(self, piece: Array, curvatures: Array, lengths: Array, way: int, now: ControlInput) -> float:
        """Return the curvature along the path with feedback [1/m]."""
        x, y, yaw = piece[0].tolist()
        dx, dy = now.pose.x - x, now.pose.y - y
        ahead = way * (math.cos(yaw) * dx + math.sin(yaw) * dy)
        preview = max(ahead, 0.0) + LATENCY / 2.0 * abs(now.velocity.linear)
        curvature = float(np.interp(preview, lengths, curvatures))
        across = math.cos(yaw) * dy - math.sin(yaw) * dx - curvature * ahead * ahead / 2.0
        turned = wrap(now.pose.yaw - yaw - way * curvature * ahead)
        decay = DECAY + DECAY_TIME * abs(now.velocity.linear)
        wanted: float = curvature - across / decay**2 - way * 2.0 * turned / decay
        return min(max(wanted, -self._most), self._most)

    def _speed_for(self, curvatures: Array, lengths: Array) -> float:
        """Return the speed at which the robot can slow down for each curve ahead [m/s]."""
        a = self._drive.max_acceleration
        bent = np.maximum(np.abs(curvatures), 1e-6)
        allowed = np.minimum(self._turn_rate / bent, np.sqrt(a / bent))
        if self._most < math.inf and len(lengths) > 1:
            rates = np.abs(np.diff(curvatures)) / np.diff(lengths)
            swing = np.maximum(np.append(rates, rates[-1]), np.append(rates[0], rates))
            allowed = np.minimum(allowed, 2.0 * self._most / (SWING_TIME * np.maximum(swing, 1e-6)))
        return float(np.sqrt(allowed**2 + 2.0 * CALM * a * lengths).min())

    # ------------------------------------------------------------ turn

    def _turn(self, error: float, now: ControlInput) -> Velocity | None:
        """Turn in place by an angle, if the outline touches nothing."""
        around = Surroundings.seen(now, self._cover.reach + self._parameters.lookahead_dist, self._known)
        count = math.ceil(min(abs(error), 0.5) / 0.05)
        ahead = np.tile(np.array(now.pose), (count, 1))
        ahead[:, 2] += math.copysign(0.05, error) * np.arange(1, count + 1)
        free = around.count_free(self._cover, ahead)
        if free == 0:
            return None
        rate = turn_rate(error, self._turn_rate)
        if free < count:
            rate = min(rate, SLOWEST_TURN)
        return Velocity(0.0, math.copysign(rate, error))


def _end_of_piece(ways: Indices, index: int) -> int:
    """Return the index of the last pose that is reached without a change of direction."""
    others = np.flatnonzero(ways[index:] != ways[index])
    return index + int(others[0]) if len(others) else len(ways)


def _curvatures(piece: Array, lengths: Array, way: int) -> Array:
    """Return the mean curvature around each pose of a piece [1/m]; the ends of short arcs are smoothed."""
    headings = np.unwrap(piece[:, 2])
    low, high = np.maximum(lengths - BLUR, 0.0), np.minimum(lengths + BLUR, lengths[-1])
    turned = np.interp(high, lengths, headings) - np.interp(low, lengths, headings)
    curvatures: Array = way * turned / np.maximum(high - low, BLUR)
    return curvatures
