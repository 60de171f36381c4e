"""The controller `holonomic`: it follows the poses of a path in any direction, turning on the way.

The base moves towards a point of the path ahead while it turns to the heading there. So it may arrive sideways. It
stops where its outline would touch a point of the scan on the path ahead.
"""

from __future__ import annotations

import math

import numpy as np

from sim_nodes.geometry import Array, Indices, Pose2, lengths_along, wrap
from sim_nodes.navigation.braking import STOP_MARGIN, TURN_GAIN
from sim_nodes.navigation.contracts import ControlInput, Path, Setup, UnsuitableRobot
from sim_nodes.navigation.following import LARGEST_VIEW, WINDOW, PoseController
from sim_nodes.navigation.surroundings import Surroundings
from sim_nodes.robots.kinematics import Velocity

LOOKAHEAD = 0.2  # [m]
LEVER = 0.2  # [m] distance that counts as much as a heading off by one radian
AHEAD = np.array([0.1, 0.2, 0.3])  # [s] from now on in which a motion must be free: two decisions and braking
REACHED = (0.004, 0.03)  # [m] and [rad] from the end of a turn, or of the way before one


class HolonomicController(PoseController):
    """The default controller of omnidirectional drives."""

    def __init__(self, setup: Setup) -> None:
        super().__init__(setup, "holonomic")
        if not self._drive.max_lateral_speed:
            raise UnsuitableRobot(
                "`holonomic` moves sideways, which the drive cannot; expected `pursuit`, or `arcs` for a robot "
                "that turns in place"
            )

    def follow(self, path: Path, now: ControlInput, *, stops: bool) -> Velocity | None:
        """See `Controller.follow`."""
        poses, pose = path.poses, now.pose
        end = self._advance(poses, path.ways, np.array(pose))
        piece = poses[self._index : end + 1]
        lengths = lengths_along(piece[:, :2])
        view = piece[: LARGEST_VIEW + 1]
        around = Surroundings.seen(now, self._reach, self._known)
        count = around.count_free(self._cover, view[1:])
        is_free = count == len(view) - 1
        if count == 0 and not is_free:
            return None
        target = piece[min(int(np.searchsorted(lengths, LOOKAHEAD)), len(piece) - 1)]
        x, y = target[0] - pose.x, target[1] - pose.y
        remaining = float(lengths[-1]) + math.hypot(*(piece[0, :2] - pose[:2]))
        speed = min(
            self._top_speed if is_free else self._braking.speed(float(lengths[count]) - STOP_MARGIN),
            self._top_speed if not stops and end == len(poses) - 1 else self._approach(remaining),
        )
        away = max(math.hypot(x, y), 1e-9)
        ahead = (math.cos(pose.yaw) * x + math.sin(pose.yaw) * y) / away
        left = (math.cos(pose.yaw) * y - math.sin(pose.yaw) * x) / away
        limit = max(abs(ahead) / self._drive.max_speed, abs(left) / self._drive.max_lateral_speed)
        speed = min(speed, 1.0 / max(limit, 1e-9), TURN_GAIN * remaining)
        turn = TURN_GAIN * wrap(float(target[2]) - pose.yaw)
        turn = min(max(turn, -self._turn_rate), self._turn_rate)
        return self._safe(Velocity(speed * ahead, turn, speed * left), around)

    def _safe(self, velocity: Velocity, around: Surroundings) -> Velocity | None:
        """Return a velocity, or that without turning or moving, whose next poses are free; None without one.

        The base turns at another pace than the path, so a corner may leave the poses of the path.
        """
        v, w, u = velocity
        for motion in (velocity, Velocity(v, 0.0, u), Velocity(0.0, w, 0.0)):
            poses = _next_poses(around.pose, motion)
            if around.count_free(self._cover, poses) == len(poses):
                return motion
        return None

    def _advance(self, poses: Array, ways: Indices, pose: Array) -> int:
        """Move on to the nearest pose ahead; returns the end of its piece: a turn, or the way before one."""
        while True:
            stands = ways[self._index :] == 0
            others = np.flatnonzero(stands != stands[:1])
            end = self._index + int(others[0]) if len(others) else len(poses) - 1
            off = poses[self._index : min(self._index + WINDOW, end) + 1] - pose
            self._index += int((np.hypot(off[:, 0], off[:, 1]) + LEVER * np.abs(wrap(off[:, 2]))).argmin())
            dx, dy, turn = poses[end] - pose
            is_at_end = math.hypot(dx, dy) < REACHED[0] and abs(wrap(float(turn))) < REACHED[1]
            if self._index < end or end == len(poses) - 1 or not is_at_end:
                return end
            self._index = end

    def _approach(self, remaining: float) -> float:
        return self._parameters.min_approach_linear_velocity + self._braking.calm_speed(remaining)


def _next_poses(pose: Pose2, velocity: Velocity) -> Array:
    """Return the poses at some times of a constant velocity, by the midpoint rule, shape (n, 3)."""
    yaw = pose.yaw + velocity.angular * AHEAD / 2.0
    x = np.cos(yaw) * velocity.linear - np.sin(yaw) * velocity.lateral
    y = np.sin(yaw) * velocity.linear + np.cos(yaw) * velocity.lateral
    return np.column_stack([pose.x + x * AHEAD, pose.y + y * AHEAD, pose.yaw + velocity.angular * AHEAD])
