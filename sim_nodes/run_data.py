"""Data recorded of a run: tracks for its plot, and measurements by true poses, which robots do not know."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import assert_never

import numpy as np

from seoro.bridges.wire import Measurements, Outcome, RobotMeasurements
from sim_nodes.entities import Entities
from sim_nodes.frames import Frames
from sim_nodes.geometry import Array, Pose2, Vector, rotation_matrix, wrap
from sim_nodes.navigation.goals import Goal
from sim_nodes.outcomes import GoalResult
from sim_nodes.physics import BodyModel, BodyState, Box, Capsule, Cylinder, Engine, Hull, Part, Sphere, Wall
from sim_nodes.robots.robot import Robot
from sim_nodes.stateful import Stateful
from sim_nodes.ticks import TICK
from sim_nodes.worlds.loader import World


class WallDistance:
    """Distances to the nearest of a set of walls."""

    def __init__(self, walls: Sequence[Wall]) -> None:
        self._centre = np.array([(wall.x, wall.y) for wall in walls]).reshape(-1, 2)
        self._half = np.array([(wall.length / 2, wall.thickness / 2) for wall in walls]).reshape(-1, 2)
        yaw = np.array([wall.yaw for wall in walls])
        self._cos, self._sin = np.cos(yaw), np.sin(yaw)

    def at(self, x: float, y: float) -> float:
        """Return the distance of a point [m]; 0 inside a wall, infinite without walls."""
        dx, dy = x - self._centre[:, 0], y - self._centre[:, 1]
        along = np.abs(self._cos * dx + self._sin * dy) - self._half[:, 0]
        across = np.abs(self._cos * dy - self._sin * dx) - self._half[:, 1]
        return float(np.hypot(along.clip(0.0), across.clip(0.0)).min(initial=np.inf))


def distance_to_body(model: BodyModel, state: BodyState, x: float, y: float) -> float:
    """Return the distance of a point to a body [m]; 0 inside. Parts at all heights count."""
    body = rotation_matrix(state.orientation)
    distances = (_distance_to_part(part, body, np.array(state.position), x, y) for part in model.parts)
    return min(distances, default=math.inf)


def _distance_to_part(part: Part, body: Array, position: Array, x: float, y: float) -> float:
    centre = position + body @ part.position
    turned = body @ rotation_matrix(part.orientation)
    local = turned.T @ np.array([x - centre[0], y - centre[1], 0.0])
    match part.shape:
        case Box(size=size):
            return float(np.hypot.reduce((np.abs(local) - np.array(size) / 2).clip(0.0)))
        case Cylinder(radius=radius, length=length):
            across = max(0.0, math.hypot(local[0], local[1]) - radius)
            return math.hypot(across, max(0.0, abs(float(local[2])) - length / 2))
        case Sphere(radius=radius):
            return max(0.0, float(np.hypot.reduce(local)) - radius)
        case Capsule(radius=radius, length=length):
            along = max(0.0, abs(float(local[2])) - length / 2)
            return max(0.0, math.hypot(local[0], local[1], along) - radius)
        case Hull():
            return _distance_to_hull(part.shape, local)
        case _:
            assert_never(part.shape)


def _distance_to_hull(hull: Hull, point: Array) -> float:
    """Return the distance of a point to a convex hull [m], by minimizing over weights of its corners."""
    from scipy.optimize import nnls  # noqa: PLC0415 - for meshes only

    # Weights of the corners are not negative and sum to one, which a large factor enforces.
    corners = hull.points.T
    scale = 1e3 * max(1.0, float(np.abs(corners - point[:, None]).max()))
    matrix = np.vstack([corners - point[:, None], np.full(corners.shape[1], scale)])
    weights, _ = nnls(matrix, np.array([0.0, 0.0, 0.0, scale]))
    return float(np.linalg.norm((corners - point[:, None]) @ weights))


STEP = 0.01  # [m] between two points of a path, or two computations of the clearance
MOVING = (0.01, 0.05)  # [m/s], [rad/s] from which a robot is moving


class Mean(Stateful):
    """A mean over time, and the maximum."""

    STATE = ("_sum", "_count", "_maximum")

    def __init__(self) -> None:
        self._sum, self._count, self._maximum = 0.0, 0, 0.0

    def add(self, value: float) -> None:
        """Add a value."""
        self._sum += value
        self._count += 1
        self._maximum = max(self._maximum, value)

    @property
    def mean(self) -> float | None:
        """Mean value; None without values."""
        return self._sum / self._count if self._count else None

    @property
    def maximum(self) -> float | None:
        """Maximum value; None without values."""
        return self._maximum if self._count else None


class RobotMetrics(Stateful):
    """The measurements of one robot, updated in every tick.

    Args:
        pose: Initial pose [m, rad].
        clearance: Returns the distance between the robot's outline and other things at a pose [m].
    """

    STATE = (
        "_pose",
        "_tick",
        "_measured_at",
        "_path_length",
        "_driving_ticks",
        "_error",
        "_error_driving",
        "_deviation",
        "_closest",
        "_contacts",
        "_goal",
        "_goals",
    )

    def __init__(self, pose: Pose2, clearance: Callable[[Pose2], float]) -> None:
        self._pose = self._measured_at = pose
        self._tick: int | None = None  # of the last update
        self._clearance = clearance
        self._path_length = 0.0
        self._driving_ticks = 0
        self._error, self._error_driving, self._deviation = Mean(), Mean(), Mean()
        self._closest = clearance(pose)
        self._contacts = 0
        self._goal: str | None = None  # navigation goal
        self._goals = dict.fromkeys(Outcome, 0)

    def update(self, pose: Pose2, believed: Pose2 | None, deviation: float | None, tick: int) -> None:
        """Update with the pose of the robot.

        Args:
            pose: True pose.
            believed: Localised pose; None before localisation.
            deviation: Standard deviation of the position by the localisation [m].
            tick: Present tick; idle robots are updated less often.
        """
        way = pose.distance(self._pose.x, self._pose.y)
        turn = abs(wrap(pose.yaw - self._pose.yaw))
        ticks = 1 if self._tick is None else tick - self._tick
        self._tick = tick
        interval = ticks * TICK
        moving = way > MOVING[0] * interval or turn > MOVING[1] * interval
        self._pose = pose
        if moving:
            self._path_length += way
            self._driving_ticks += ticks
            if pose.distance(self._measured_at.x, self._measured_at.y) >= STEP:
                self._measured_at = pose
                self._closest = min(self._closest, self._clearance(pose))
        if believed is not None and deviation is not None:
            error = believed.distance(pose.x, pose.y)
            self._error.add(error)
            self._deviation.add(deviation)
            if moving:
                self._error_driving.add(error)

    def count_contact(self) -> None:
        """Count a contact."""
        self._contacts += 1

    def start_goal(self, goal: str) -> None:
        """Start a navigation goal by its id."""
        self._goal = goal

    def end_goal(self, goal: str, outcome: Outcome) -> None:
        """Count the result of a goal if it is the navigation goal; robots have goals of other kinds, too."""
        if goal == self._goal:
            self._goal = None
            self._goals[outcome] += 1

    def result(self, recoveries: int) -> RobotMeasurements:
        """Return the measurements so far, with the number of recoveries."""
        return RobotMeasurements(
            path_length=self._path_length,
            driving_time=self._driving_ticks * TICK,
            localisation_error=self._error.mean,
            localisation_error_driving=self._error_driving.mean,
            localisation_error_max=self._error.maximum,
            localisation_deviation=self._deviation.mean,
            closest_approach=self._closest if math.isfinite(self._closest) else None,
            contacts=self._contacts,
            goals_reached=self._goals[Outcome.SUCCEEDED],
            goals_aborted=self._goals[Outcome.ABORTED],
            goals_canceled=self._goals[Outcome.CANCELED],
            recoveries=recoveries,
        )


Point = tuple[float, float]


@dataclass
class RobotTrack(Stateful):
    """Track of a robot by its true poses: start, path of base and tool, and goals."""

    STATE = ("start", "path", "times", "goals", "tool")

    start: Pose2
    path: list[Point] = field(default_factory=list)  # [m], in the map
    times: list[float] = field(default_factory=list)  # [s] of the points of the path
    goals: list[Pose2] = field(default_factory=list)
    tool: list[Vector] = field(default_factory=list)  # [m], in the map

    def add_pose(self, pose: Pose2, time: float) -> None:
        """Add a pose of the robot."""
        if not self.path or pose.distance(*self.path[-1]) >= STEP:
            self.path.append((pose.x, pose.y))
            self.times.append(time)


def _add(path: list[Vector], position: Vector) -> None:
    if not path or math.dist(path[-1], position) >= STEP:
        path.append(position)


TOOL_TICKS, TRAIL_TICKS = 2, 5  # between records of tools, and of spawned bodies


class RunData(Stateful):
    """The recorded data of one run.

    Args:
        engine: Engine with the present states.
        world: The world.
        entities: Entities of the world.
        robots: Robots by name.
        frames: Frames with the true poses of robots.
        starts: Initial poses of robots.

    Attributes:
        records: Tracks of robots by name.
        trails: Paths of movable bodies in `map` [m], by name.
    """

    STATE = ("records", "trails", "_since", "_measuring")

    def __init__(
        self,
        engine: Engine,
        world: World,
        entities: Entities,
        robots: Mapping[str, Robot],
        frames: Frames,
        starts: Mapping[str, Pose2],
    ) -> None:
        self._engine = engine
        self._world = world
        self._entities = entities
        self._robots = robots
        self._frames = frames
        self.records = {name: RobotTrack(start) for name, start in starts.items()}
        self.trails: dict[str, list[Vector]] = {}
        self._since: dict[str, float] = {}  # times at which the bodies of the trails were spawned [s]
        self._walls = WallDistance(world.walls)
        self._radii = {name: robot.mobile.declaration.radius for name, robot in robots.items() if robot.drives}
        self._measuring = {
            name: RobotMetrics(frames.true_pose(name), partial(self._clearance, name)) for name in self._radii
        }

    def _clearance(self, robot: str, pose: Pose2) -> float:
        """Return the distance from a robot's circle at a pose to the nearest obstacle [m]; 0 at least.

        Obstacles are walls, spawned bodies, and other wheeled robots.
        """
        distances = [self._walls.at(pose.x, pose.y)]
        for name, spawned in self._entities.spawned.items():
            distances.append(distance_to_body(spawned.model, self._engine.body_state(name), pose.x, pose.y))
        for other, radius in self._radii.items():
            if other != robot:
                there = self._engine.body_state(other).planar
                distances.append(pose.distance(there.x, there.y) - radius)
        return max(0.0, min(distances) - self._radii[robot])

    def record_pose(self, robot: Robot, time: float, tick: int) -> None:
        """Record the pose of a robot at a time [s]."""
        pose = self._frames.true_pose(robot.name)
        self.records[robot.name].add_pose(pose, time)
        if robot.drives:
            base = robot.mobile
            self._measuring[robot.name].update(pose, base.localised_pose(), base.deviation(), tick)

    def record_positions(self, tick: int) -> None:
        """Record the positions of tools and movable bodies."""
        for robot in self._robots.values():
            arm = robot.declaration.arm
            if arm is not None and tick % TOOL_TICKS == 0:
                _add(self.records[robot.name].tool, self._engine.link_pose(robot.name, arm.tool_link)[0])
        if tick % TRAIL_TICKS == 0:
            since = self._entities.movable()
            for name in self.trails.keys() - since.keys():
                del self.trails[name], self._since[name]
            for name, time in since.items():
                if self._since.get(name) != time:
                    self.trails[name], self._since[name] = [], time
                _add(self.trails[name], self._engine.body_state(name).position)

    def record_contact(self, first: str, second: str) -> None:
        """Record a contact."""
        for robot in self._measuring.keys() & {first, second}:
            self._measuring[robot].count_contact()

    def record_goal(self, robot: str, goal: Goal) -> None:
        """Record a navigation goal."""
        self.records[robot].goals.extend(goal.poses)
        self._measuring[robot].start_goal(goal.id)

    def record_result(self, robot: str, end: GoalResult) -> None:
        """Record the result of a robot's goal."""
        if robot in self._measuring:
            self._measuring[robot].end_goal(end.id, end.outcome)

    def measurements(self, seed: int, time: float) -> Measurements:
        """Return the measurements of wheeled robots up to a time [s]."""
        robots = self._robots
        return Measurements(
            world=self._world.name,
            engine=self._engine.name,
            engine_version=self._engine.version,
            seed=seed,
            time=time,
            robots={name: each.result(robots[name].mobile.recoveries) for name, each in self._measuring.items()},
        )
