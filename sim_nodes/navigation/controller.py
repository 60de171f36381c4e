"""The controller `arcs`: it follows a path along the best of some arcs that are free of obstacles.

The first arcs lead to points of the path, as in pure pursuit (Coulter 1992). A fan of others leads around
obstacles. Each arc ends where the robot would come too close to a point of the scan, so that errors of the
localisation do not matter there. The arc whose end is nearest to the point ahead on the path is best. The robot
turns in place if that point is not ahead, and drives no faster than it can stop before the end of its arc.

Robots of a kind that decide in the same tick are computed together; the results are those of each one alone.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from seoro.deferred import dataclass
from sim_nodes.geometry import Array, Pose2
from sim_nodes.navigation.arcs import arc_points, free_lengths
from sim_nodes.navigation.braking import STOP_MARGIN, Braking, turn_rate
from sim_nodes.navigation.contracts import ControlInput, Controller, Following, Path, Setup, UnsuitableRobot
from sim_nodes.navigation.surroundings import MAP_SLACK, points_around
from sim_nodes.robots.kinematics import Velocity

FAN = (0.0, 0.4, 0.9, 1.6, 2.5, 3.6, 5.0, 8.0)  # curvatures [1/m], to both sides
AHEAD = (1.0, 0.6, 0.35)  # points of the path that arcs lead to, relative to the look-ahead
STEADINESS = 0.004  # [m / (1/m)]; cost of a change of curvature
PROGRESS = 0.01  # [m] that an arc must lead towards the point ahead
MOST_NOISE = 0.02  # [m] of a lidar that the robot keeps away beyond its clearance
OPEN = 0.02  # [m]; a shorter arc is blocked
FACING = 0.2  # [rad] to the point ahead at which turning in place ends
SAMPLES = 5  # points of an arc that are looked up on the map
DONE = 1e-3  # [m]


@dataclass(frozen=True)
class Ahead:
    """The path ahead of a robot.

    Attributes:
        points: Points x, y on the path in the frame of the base, farthest first [m].
        rest: Length of the rest of the path [m].
        distance: Distance of the first point [m].
        bearing: Bearing of the first point [rad].
    """

    points: tuple[tuple[float, float], ...]
    rest: float
    distance: float
    bearing: float


class ArcController(Controller):
    """The default controller of robots that turn in place, along paths without headings.

    It keeps a circle free, as planners do without headings, also around a polygon.
    """

    STATE = ("_is_turning", "_curvature")
    FOLLOWS_HEADINGS = False

    def __init__(self, setup: Setup) -> None:
        setup.refuse_parameters("controller `arcs`")
        self._declared = declared = setup.declaration
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
        self._fan = np.array([*(-curve for curve in FAN[:0:-1]), *FAN])
        self._ahead = tuple(p.lookahead_dist * share for share in AHEAD)
        self._reach = p.lookahead_dist + self._clearance + self._braking.room(self._top_speed)
        self._longest = p.lookahead_dist + self._braking.room(self._top_speed)  # of arcs [m]
        self._samples = np.linspace(self._longest / SAMPLES, self._longest, SAMPLES)
        self.begin()

    @property
    def kind(self) -> tuple[int, int]:
        """Equal for controllers of equal robots on the same map, which `follow_together` accepts together."""
        return id(self._declared), id(self._known)

    def begin(self) -> None:
        """See `Controller.begin`."""
        self._is_turning = False
        self._curvature = 0.0

    def follow(self, path: Path, now: ControlInput, *, stops: bool) -> Velocity | None:
        """See `Controller.follow`."""
        return follow_together([Following(self, path, now, stops)])[0]

    def look_ahead(self, path: Path, pose: Pose2) -> Ahead:
        """Return the path ahead of a pose in `map`."""
        index, to_base = path.nearest(pose.x, pose.y), pose.inverse()
        rest, last = float(path.to_go[index]), len(path.points) - 1
        cos, sin = math.cos(to_base.yaw), math.sin(to_base.yaw)
        points = []
        for distance in self._ahead:
            x, y = path.points[min(max(path.index_at(rest - distance), index), last)].tolist()
            points.append((to_base.x + cos * x - sin * y, to_base.y + sin * x + cos * y))
        x, y = points[0]
        distance = math.hypot(x, y)
        return Ahead(tuple(points), rest, distance, math.atan2(y, x) if distance > DONE else 0.0)

    def must_turn(self, ahead: Ahead) -> bool:
        """Whether the robot has to turn in place towards the path."""
        limit = FACING if self._is_turning else self._parameters.rotate_to_heading_min_angle
        self._is_turning = abs(ahead.bearing) > limit and ahead.distance > DONE
        return self._is_turning

    def turn(self, bearing: float) -> Velocity:
        """Turn in place towards a bearing."""
        self._curvature = 0.0
        return Velocity(0.0, math.copysign(turn_rate(bearing, self._turn_rate), bearing))

    def rate_arcs(self, aheads: Sequence[Ahead], calls: Sequence[Following[ArcController]]) -> Arcs:
        """Rate the arcs of robots of this kind, each with its path ahead."""
        points = np.array([ahead.points for ahead in aheads])
        x, y = points[..., 0], points[..., 1]
        fan = np.broadcast_to(self._fan, (len(calls), len(self._fan)))
        curvatures = np.concatenate([2.0 * y / np.maximum(x * x + y * y, DONE), fan], axis=1)
        free = self._free_lengths(curvatures, [call.now for call in calls])
        distance = np.array([[ahead.distance] for ahead in aheads])
        reached = np.minimum(free, np.minimum(distance, self._parameters.lookahead_dist))
        end_x, end_y = arc_points(curvatures, reached)
        missing = np.hypot(end_x - x[:, :1], end_y - y[:, :1])
        before = np.array([[call.controller._curvature] for call in calls])
        costs = missing + STEADINESS * np.abs(curvatures - before)
        half = distance / 2.0
        costs[(reached < np.minimum(OPEN, half)) | (missing > distance - np.minimum(PROGRESS, half))] = np.inf
        return Arcs(curvatures, free, costs)

    def _free_lengths(self, curvatures: Array, inputs: Sequence[ControlInput]) -> Array:
        """Return the free lengths of arcs among points of scans, remembered ones and walls of the map [m]."""
        free = free_lengths(curvatures, points_around(inputs, self._reach), self._limit, self._longest)
        return np.minimum(free, self._free_on_map(curvatures, [now.pose for now in inputs]))

    def _free_on_map(self, curvatures: Array, poses: Sequence[Pose2]) -> Array:
        """Return the lengths of arcs before walls of the map [m], for what lidars do not see."""
        grid, distance = self._known.grid, self._known.distance
        free = np.full(curvatures.shape, np.inf)
        near, at = [], []
        for robot, pose in enumerate(poses):
            here = float(distance[grid.cell(pose.x, pose.y)])
            least = min(self._clearance, here) - MAP_SLACK
            if here - self._longest - 2.0 * grid.resolution <= least:  # a wall is that close
                near.append(robot)
                at.append((pose.x, pose.y, math.cos(pose.yaw), math.sin(pose.yaw), least))
        if not near:
            return free
        px, py, cos, sin, room_needed = np.array(at).T[:, :, None, None]
        x, y = arc_points(curvatures[near, :, None], self._samples)
        blocked = distance[grid.cells(px + cos * x - sin * y, py + sin * x + cos * y)] < room_needed
        first = blocked.argmax(axis=2) * (self._longest / SAMPLES)
        free[near] = np.where(blocked.any(axis=2), first, np.inf)
        return free

    def choose(self, ahead: Ahead, arcs: Arcs, robot: int, *, stops: bool) -> Velocity | None:
        """Return the velocity along the best arc of a robot; without one, turn to the path or stop."""
        best = int(arcs.costs[robot].argmin())
        if not math.isfinite(arcs.costs[robot, best]):
            return self.turn(ahead.bearing) if abs(ahead.bearing) > FACING else None
        self._curvature = float(arcs.curvatures[robot, best])
        free, rest = float(arcs.free[robot, best]), ahead.rest if stops else math.inf
        speed = min(
            self._top_speed,
            self._braking.speed(free - STOP_MARGIN),
            self._turn_rate / max(abs(self._curvature), 1e-6),
            self._parameters.min_approach_linear_velocity + rest,
        )
        return Velocity(speed, speed * self._curvature)


@dataclass(frozen=True)
class Arcs:
    """Arcs of robots; each array has the shape (robots, arcs).

    Attributes:
        curvatures: Curvatures [1/m].
        free: Lengths up to obstacles [m].
        costs: Costs; infinite for arcs that are blocked or lead nowhere [m].
    """

    curvatures: Array
    free: Array
    costs: Array


def follow_together(calls: Sequence[Following[ArcController]]) -> list[Velocity | None]:
    """Answer calls of `follow` of controllers of one kind, as each of them alone does."""
    velocities: list[Velocity | None] = [None] * len(calls)
    driving, aheads = [], []
    for number, call in enumerate(calls):
        ahead = call.controller.look_ahead(call.path, call.now.pose)
        if call.controller.must_turn(ahead):
            velocities[number] = call.controller.turn(ahead.bearing)
        else:
            driving.append(number)
            aheads.append(ahead)
    if driving:
        chosen = [calls[number] for number in driving]
        arcs = chosen[0].controller.rate_arcs(aheads, chosen)
        for robot, (call, ahead) in enumerate(zip(chosen, aheads, strict=True)):
            velocities[driving[robot]] = call.controller.choose(ahead, arcs, robot, stops=call.stops)
    return velocities
