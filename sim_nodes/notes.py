"""What is noted of a run for its picture and its measurements; robots know nothing of it."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from seoro.bridges.wire import Measurements
from sim_nodes.clearance import Surroundings
from sim_nodes.entities import Entities
from sim_nodes.frames import Frames
from sim_nodes.geometry import Pose2
from sim_nodes.goals import Ended
from sim_nodes.measurements import Measuring
from sim_nodes.navigation.navigator import Goal
from sim_nodes.physics import Engine
from sim_nodes.record import RobotRecord, Trails
from sim_nodes.robots.robot import Robot
from sim_nodes.stateful import Stateful
from sim_nodes.ticks import TICK
from sim_nodes.worlds.loader import World

TOOL_TICKS, TRAIL_TICKS = 2, 5  # between looks at tools of arms, and at what was spawned


class Notes(Stateful):
    """The notes of one run.

    Args:
        engine: Has the world.
        world: The world.
        entities: What is in it besides robots.
        robots: The robots.
        frames: Says where they really are.
        starts: Where they are at the beginning.

    Attributes:
        records: Of the robots, by name.
        trails: Of what was spawned.
    """

    STATE = ("records", "trails", "_measuring")

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
        self.records = {name: RobotRecord(start) for name, start in starts.items()}
        self.trails = Trails()
        driving = [robot for robot in robots.values() if robot.drives]
        radii = {robot.name: robot.mobile.declaration.radius for robot in driving}
        room = Surroundings(engine, world.walls, entities, radii).room
        self._measuring = {name: Measuring(frames.true_pose(name), partial(room, name), TICK) for name in radii}

    def passed(self, robot: Robot, time: float, tick: int) -> None:
        """Note where a robot is, at a time [s]."""
        pose = self._frames.true_pose(robot.name)
        self.records[robot.name].passed(pose, time)
        if robot.drives:
            base = robot.mobile
            self._measuring[robot.name].passed(pose, base.localised_pose(), base.deviation(), tick)

    def note_places(self, tick: int) -> None:
        """Note where tools of arms are, and what was spawned."""
        for robot in self._robots.values():
            arm = robot.declaration.arm
            if arm is not None and tick % TOOL_TICKS == 0:
                self.records[robot.name].tool_passed(self._engine.link_pose(robot.name, arm.tool_link)[0])
        if tick % TRAIL_TICKS == 0:
            self.trails.note(self._entities.movable(), lambda name: self._engine.body_state(name).position)

    def touched(self, first: str, second: str) -> None:
        """Note that two touch."""
        for robot in self._measuring.keys() & {first, second}:
            self._measuring[robot].touched()

    def sent(self, robot: str, goal: Goal) -> None:
        """Note that a robot is on its way to a goal."""
        self.records[robot].goals.extend(goal.poses)
        self._measuring[robot].sent(goal.id)

    def ended(self, robot: str, end: Ended) -> None:
        """Note the end of a robot's goal."""
        if robot in self._measuring:
            self._measuring[robot].ended(end.id, end.outcome)

    def measurements(self, seed: int, time: float) -> Measurements:
        """What was measured of the robots that drive, until a time [s]."""
        robots = self._robots
        return Measurements(
            world=self._world.name,
            engine=self._engine.name,
            engine_version=self._engine.version,
            seed=seed,
            time=time,
            robots={name: each.result(robots[name].mobile.recoveries) for name, each in self._measuring.items()},
        )
