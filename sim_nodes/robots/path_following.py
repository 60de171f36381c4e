"""Robots that follow a path by their true pose, without a map, a localisation or sensors.

The steering is pure pursuit (Coulter, CMU-RI-TR-92-01, 1992): an arc leads to a point of the path ahead. For the
bearing e and the distance d of that point, its curvature is 2 sin(e) / d. Robots that turn in place face it first.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

from seoro.bridges.wire import Outcome
from seoro.deferred import dataclass
from sim_nodes.geometry import Pose2, wrap
from sim_nodes.outcomes import GoalResult
from sim_nodes.robots.drive_declaration import DriveDeclaration
from sim_nodes.robots.kinematics import AT_REST, Velocity
from sim_nodes.stateful import Stateful
from sim_nodes.ticks import TICK

AHEAD = 0.25  # [m] along the path to the point that is pursued; at least the turning radius
ARRIVED = 0.03  # [m] from the last point
CREEP = 0.03  # [m/s] minimum speed before the last point
BRAKING = 0.5  # share of the acceleration with which a robot brakes before it
FACING = 0.6  # [rad] bearing, or bend of the path, beyond which robots turn in place
TURN_TIME = 0.3  # [s] to turn to the point
PATIENCE = round(20.0 / TICK)  # ticks without progress after which a goal is aborted
PROGRESS = 0.1  # [m]

Point = tuple[float, float]  # [m]


@dataclass(frozen=True)
class Path:
    """A path with the progress on it.

    Attributes:
        points: Its points; the first one is the start.
        speed: [m/s]
        repeat: Whether the second point follows the last one, without an end.
        goal: Id of the goal; None without a client that waits.
        before: Index of the last point passed.
        index: Index of the next point.
        nearest: Smallest remaining length so far [m].
        since: Tick of the last progress.
    """

    points: tuple[Point, ...]
    speed: float
    repeat: bool
    goal: str | None
    before: int = 0
    index: int = 1
    nearest: float = math.inf
    since: int = 0

    @property
    def is_last(self) -> bool:
        """Whether it ends at the next point."""
        return not self.repeat and self.index == len(self.points) - 1

    @property
    def bend(self) -> float:
        """Angle between the present line and the one after it, from 0 to pi [rad]."""
        (ax, ay), (bx, by) = self.line
        cx, cy = self.passed().line[1]
        return abs(float(wrap(math.atan2(cy - by, cx - bx) - math.atan2(by - ay, bx - ax))))

    def passed(self) -> Path:
        """Return the path behind the next point."""
        following = self.index + 1 if self.index + 1 < len(self.points) else 1
        return replace(self, before=self.index, index=following)

    @property
    def line(self) -> tuple[Point, Point]:
        """The present line, from the point before to the next one."""
        return self.points[self.before], self.points[self.index]


class PathFollower(Stateful):
    """The path of a base, if any.

    Args:
        drive: Declaration of its drive.
    """

    STATE = ("path",)

    def __init__(self, drive: DriveDeclaration) -> None:
        self._drive = drive
        self.path: Path | None = None

    def start(self, points: Sequence[Point], speed: float, tick: int, goal: str | None, *, repeat: bool) -> None:
        """Start a path; `points` begin with the start."""
        self.path = Path(tuple(points), speed, repeat, goal, since=tick)

    def control(self, pose: Pose2, tick: int) -> tuple[Velocity, GoalResult | None]:
        """Return the wanted velocity at a pose, and the result of the goal if it ends; requires a path."""
        path = self.path
        assert path is not None
        path = self._advanced(path, pose)
        left = _remaining(path, pose)
        if path.is_last and (left <= ARRIVED or _along(path.line, pose) >= math.dist(*path.line)):
            return self._end(path, Outcome.SUCCEEDED)
        if left < path.nearest - PROGRESS:
            path = replace(path, nearest=left, since=tick)
        elif not path.repeat and tick - path.since > PATIENCE:
            where = f"({pose.x:.2f}, {pose.y:.2f})"
            message = f"the robot is blocked at {where}: no progress in {PATIENCE * TICK:g} s"
            return self._end(path, Outcome.ABORTED, message)
        self.path = path
        braking = math.sqrt(2.0 * BRAKING * self._drive.max_acceleration * left)
        speed = path.speed if path.repeat else min(path.speed, max(braking, CREEP))
        return self._pursue(self._target(path, pose), pose, speed), None

    def _end(self, path: Path, outcome: Outcome, message: str = "") -> tuple[Velocity, GoalResult | None]:
        self.path = None
        return AT_REST, None if path.goal is None else GoalResult(path.goal, outcome, message)

    @property
    def _ahead(self) -> float:
        return max(AHEAD, self._drive.min_turning_radius)

    def _advanced(self, path: Path, pose: Pose2) -> Path:
        """Return the path with the next point that is ahead."""
        for _ in path.points:
            start, end = path.line
            # A robot that steers passes beside the points of sharp turns.
            passed = max(ARRIVED, self._drive.min_turning_radius)
            if path.is_last or (pose.distance(*end) > passed and _along(path.line, pose) < math.dist(start, end)):
                return path
            path = path.passed()
        return path

    def _target(self, path: Path, pose: Pose2) -> Point:
        """Return the point of the path to pursue."""
        along, left = max(0.0, _along(path.line, pose)), self._ahead
        for _ in path.points:
            (x, y), end = path.line
            length = math.dist((x, y), end)
            if along + left < length:
                share = (along + left) / length
                return x + share * (end[0] - x), y + share * (end[1] - y)
            if path.is_last or (not self._drive.min_turning_radius and path.bend > FACING):
                return end
            left -= max(0.0, length - along)
            along, path = 0.0, path.passed()
        return path.line[1]

    def _pursue(self, target: Point, pose: Pose2, speed: float) -> Velocity:
        """Return the velocity on the arc to a point."""
        drive, distance = self._drive, pose.distance(*target)
        bearing = float(wrap(math.atan2(target[1] - pose.y, target[0] - pose.x) - pose.yaw))
        radius, fastest = drive.min_turning_radius, drive.max_turn_rate
        if not radius and abs(bearing) > FACING:
            return Velocity(0.0, min(max(bearing / TURN_TIME, -fastest), fastest))
        curvature = 2.0 * math.sin(bearing) / max(distance, ARRIVED)
        if radius:
            sharpest = 1.0 / radius
            if abs(bearing) > math.pi / 2.0:
                curvature = math.copysign(sharpest, bearing)
            curvature = min(max(curvature, -sharpest), sharpest)
        if abs(curvature) * speed > fastest:
            speed = fastest / abs(curvature)
        return Velocity(speed, curvature * speed)


def _along(line: tuple[Point, Point], pose: Pose2) -> float:
    """Return the distance of a position along a line from its start [m]."""
    (ax, ay), (bx, by) = line
    length = math.hypot(bx - ax, by - ay)
    if length == 0.0:
        return 0.0
    return ((pose.x - ax) * (bx - ax) + (pose.y - ay) * (by - ay)) / length


def _remaining(path: Path, pose: Pose2) -> float:
    """Return the length from a position over the remaining points [m], of one round of a repeated path."""
    rest = ((pose.x, pose.y), *path.points[path.index :])
    return sum(math.dist(a, b) for a, b in pairwise(rest))
