"""Data recorded of a run: tracks for its plot, and measurements by true poses, which robots do not know."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field

from seoro.bridges.wire import Measurements, RobotMeasurements
from seoro.deferred import dataclass
from sim_nodes.clearance import Clearance, Clearances, Search
from sim_nodes.entities import Entities
from sim_nodes.frames import Frames
from sim_nodes.geometry import Pose2, Vector
from sim_nodes.metrics import EntityMetrics, RobotMetrics, Rooms
from sim_nodes.navigation.goals import Goal
from sim_nodes.outcomes import GoalResult
from sim_nodes.path_efficiency import efficiency
from sim_nodes.physics import Engine, MeasuresWork
from sim_nodes.robots.robot import Robot
from sim_nodes.stateful import Stateful
from sim_nodes.terrain.surface import Surface
from sim_nodes.trajectories import Trajectories
from sim_nodes.worlds.loader import World

STEP = 0.01  # [m] between two points of a path
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
        surface: The ground, and the map of the world.
        starts: Initial poses of robots.
        touches: Returns whether an entity is in contact.
        tick: Present tick.

    Attributes:
        records: Tracks of robots by name.
        trails: Paths of movable bodies in `map` [m], by name.
        trajectories: Samples of poses, commands and joints over time.
    """

    STATE = ("records", "trails", "trajectories", "_since", "_measuring", "_entity_metrics", "_work_before")

    def __init__(
        self,
        engine: Engine,
        world: World,
        entities: Entities,
        robots: Mapping[str, Robot],
        frames: Frames,
        surface: Surface,
        starts: Mapping[str, Pose2],
        touches: Callable[[str], bool],
        tick: int,
    ) -> None:
        self._engine = engine
        self._world = world
        self._entities = entities
        self._robots = robots
        self._frames = frames
        self._surface = surface
        self.records = {name: RobotTrack(start) for name, start in starts.items()}
        self.trails: dict[str, list[Vector]] = {}
        self._since: dict[str, float] = {}  # times at which the bodies of the trails were spawned [s]
        self._bases = {name: robot.mobile.declaration for name, robot in robots.items() if robot.drives}
        self.clearances = Clearances(engine, world.walls, entities, self._bases)
        self._working = engine if isinstance(engine, MeasuresWork) else None
        self._work_before = {name: self._total_work(name) for name in robots}  # of the run [J]
        self._rooms = Rooms({pose.name: pose.room for pose in world.poses if pose.room is not None})
        self._mobiles = {name: robot.mobile for name, robot in robots.items() if robot.drives}
        self._measuring = {
            name: RobotMetrics(pose, self._nearest(name, pose), self._rooms, self._lever_of(name))
            for name, pose in ((name, frames.true_pose(name)) for name in robots)
        }
        self._entity_metrics: dict[str, EntityMetrics] = {}
        self._tools = {
            name: arm.tool_link
            for name, robot in robots.items()
            if (arm := robot.declaration.arm) is not None and arm.tool_link is not None
        }
        self.trajectories = Trajectories(engine, robots, entities, touches, tick)

    def _nearest(self, robot: str, pose: Pose2) -> Clearance:
        """Return the nearest entity; robots that do not drive have no outline."""
        return self.clearances.nearest([Search(robot, pose)])[0] if robot in self._bases else Clearance()

    def _lever_of(self, robot: str) -> float:
        """Return how far a point of a robot's outline moves relative to its base in a turn [m/rad]."""
        base = self._bases.get(robot)
        return 0.0 if base is None or base.footprint is None else base.footprint.radius

    def record_poses(self, robots: Sequence[Robot], time: float, tick: int) -> None:
        """Record the poses of robots at a time [s]."""
        searches = []
        for robot in robots:
            name = robot.name
            state = self._engine.body_state(name)
            pose, (vx, vy, _) = state.planar, state.linear
            self.records[name].add_pose(pose, time)
            self.trajectories.record_robot(robot, tick)
            believed = deviation = None
            if (base := self._mobiles.get(name)) is not None:
                believed, deviation = base.localised_pose(), base.deviation()
            within = self._measuring[name].update(pose, math.hypot(vx, vy), believed, deviation, tick)
            if within is not None and base is not None:
                searches.append(Search(name, pose, within))
        if searches:
            for search, found in zip(searches, self.clearances.nearest(searches), strict=True):
                self._measuring[search.robot].approach(found)

    def record_positions(self, tick: int, *, at_rest: bool) -> None:
        """Record the positions of tools and movable bodies.

        Args:
            tick: Present tick.
            at_rest: Whether robots, people, doors and lifts are at rest; such ticks depend on grants and watches.
        """
        if tick % TOOL_TICKS == 0:
            for name, link in self._tools.items():
                _add(self.records[name].tool, self._engine.link_pose(name, link)[0])
        if at_rest:
            return
        self.trajectories.record_bodies(tick)
        if tick % TRAIL_TICKS == 0:
            self.follow_bodies(tick)
            for name in self.trails:
                state = self._engine.body_state(name)
                _add(self.trails[name], state.position)
                speed = math.hypot(state.linear[0], state.linear[1])
                self._entity_metrics[name] = self._entity_metrics[name].updated(
                    state.position, speed, tick, self._rooms
                )

    def follow_bodies(self, tick: int) -> None:
        """Start to measure new movable bodies, and drop deleted ones."""
        since = self._entities.movable()
        for name in self.trails.keys() - since.keys():
            del self.trails[name], self._since[name]
            self._entity_metrics.pop(name, None)
        for name, time in since.items():
            if self._since.get(name) != time:
                position = self._engine.body_state(name).position
                self.trails[name], self._since[name] = [position], time
                self._entity_metrics[name] = EntityMetrics(tick, position, position)

    def record_contact(self, first: str, second: str) -> None:
        """Record a contact."""
        self.trajectories.record_contact(first, second)
        for name, other in ((first, second), (second, first)):
            if name in self._measuring:
                self._measuring[name].count_contact(other)
            if name in self._entity_metrics:
                self._entity_metrics[name] = self._entity_metrics[name].touched(other)

    def record_goal(self, robot: str, goal: Goal) -> None:
        """Record a navigation goal."""
        self.records[robot].goals.extend(goal.poses)
        self._measuring[robot].start_goal(goal)

    def work_of(self, robot: str) -> float | None:
        """Return the mechanical work of a robot's motors so far [J]; None if it is unknown."""
        if self._working is None or robot not in self._work_before:
            return None
        return self._total_work(robot) - self._work_before[robot]

    def _total_work(self, robot: str) -> float:
        return 0.0 if self._working is None else self._working.motor_work(robot)

    def record_result(self, robot: str, end: GoalResult) -> None:
        """Record the result of a robot's goal."""
        if robot in self._measuring:
            self._measuring[robot].end_goal(end.id, end.outcome)

    def measurements(self, seed: int, time: float) -> Measurements:
        """Return the measurements of robots and movable entities up to a time [s]."""
        return Measurements(
            world=self._world.name,
            engine=self._engine.name,
            engine_version=self._engine.version,
            seed=seed,
            time=time,
            robots={name: self._measured(name) for name in self._measuring},
            entities={name: each.result(self._rooms) for name, each in self._entity_metrics.items()},
        )

    def _measured(self, name: str) -> RobotMeasurements:
        metrics, robot, work = self._measuring[name], self._robots[name], self.work_of(name)
        if not robot.drives:
            return metrics.result(0, work)
        base = robot.mobile
        energy = None if base.battery is None else base.battery.drawn
        shortest = efficiency(metrics.drives, self._surface.passable(self._bases[name]), self._bases[name].radius)
        return metrics.result(base.recoveries, work, energy, shortest)
