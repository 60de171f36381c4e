"""One simulated world: time, entities, goals, watches and contacts; independent of engines and Zenoh.

Time is counted in physics steps. Everything else happens in ticks of 20 ms: robots sense and act, watches are
checked. Contacts are detected in the step in which they begin. Events are pending until they are collected.
"""

from __future__ import annotations

import math
from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from threading import Event
from typing import Any

import numpy as np

from seoro.bridges import wire
from seoro.bridges.wire.refusal import RequestRefused, name_list
from sim_nodes.agents.agent import Motion
from sim_nodes.agents.agents import Agents
from sim_nodes.agents.drawing import draw_agents
from sim_nodes.agents.walls import Walls
from sim_nodes.buildings.buildings import Buildings
from sim_nodes.clearance import Clearance
from sim_nodes.departures import Departures, check_state
from sim_nodes.entities import Entities
from sim_nodes.event_log import EventLog, WorldEvent
from sim_nodes.faults.devices import FreeCameras
from sim_nodes.faults.registry import FaultRegistry
from sim_nodes.frames import Frames
from sim_nodes.geometry import Array, Pose2
from sim_nodes.manipulation.arm import Arm
from sim_nodes.messages import contact_message, feedback_message
from sim_nodes.navigation.goals import Goal
from sim_nodes.navigation.maps import NavigationMap, build_map
from sim_nodes.outcomes import NO_CLIENT, GoalResult, operation_failed, unknown
from sim_nodes.pace import Batches
from sim_nodes.physics import BodyState, DrivesBodies, Engine, MeasuresWork, PlacedRobot
from sim_nodes.recording import Recording
from sim_nodes.robots.drive import COMMAND_TIMEOUT, VelocityCommand
from sim_nodes.robots.fleet import navigate, sense
from sim_nodes.robots.kinematics import Velocity
from sim_nodes.robots.robot import Robot
from sim_nodes.run_data import RunData
from sim_nodes.sensors.sensor_pipeline import Sample, SensorPipeline
from sim_nodes.stateful import Stateful
from sim_nodes.streams import Streams
from sim_nodes.strikes import Contacts, Strikes
from sim_nodes.terrain.surface import Surface
from sim_nodes.ticks import IDLE_TICKS, TICK
from sim_nodes.views import Picture
from sim_nodes.watches import Watch, Watches
from sim_nodes.worlds.loader import World

NO_POSES = np.zeros((0, 3))
GoalOwner = Robot | FaultRegistry | Agents | Buildings


class Simulation(Stateful):
    """A world in an engine.

    Args:
        engine: The engine; its scene is replaced.
        world: The world.
        seed: Seed of all randomness.

    Attributes:
        watches: Watches of clients.
        pending: Events since the last call of `collect`.
    """

    STATE = (
        "_steps",
        "_epoch",
        "watches",
        "_touched",
        "strikes",
        "departures",
        "entities",
        "agents",
        "buildings",
        "camera_faults",
        "robots",
        "run_data",
        "pending",
    )

    DERIVED = ("streams", "log", "halted", "_batches")  # of the simulator and the machine

    def __init__(self, engine: Engine, world: World, seed: int) -> None:
        self.engine = engine
        self.world = world
        self.seed = seed
        self.known = build_map(world.extent, world.walls, world.outlines)
        self._surface = Surface(world.ground, self.known)
        self._walls = Walls(self.known)
        circles = _robot_circles(world.robots).values()
        self._drawn = draw_agents(world.agents, world.name, seed, self._walls, circles)
        self._tick_steps = round(TICK * engine.steps_per_second)
        self.recording = Recording(engine, world, lambda: self.entities)
        self.streams = Streams()
        self.log = EventLog()
        self.halted = Event()
        self._batches = Batches()
        self._start_over()

    def _start_over(self) -> None:
        self.engine.build(self.world.scene)
        self._steps = 0
        self._epoch = 0  # step at which the clock shows zero
        self.watches = Watches()
        self._touched = Contacts(self.engine.steps_per_second)
        self.entities = Entities(self.engine, self.world, self.seed, self._drawn)
        self._make_robots()
        self.pending: list[WorldEvent] = []

    def _make_robots(self) -> None:
        placed = self.world.robots
        self.camera_faults = FaultRegistry("", FreeCameras(self.entities.cameras))
        self.robots = {
            robot.name: Robot(robot, self.engine, self.entities, self._surface, self.seed, self.world.origin)
            for robot in placed
        }
        self._rendered = tuple(pipeline for robot in self.robots.values() for pipeline in robot.rendered_sensors)
        radii = {name: radius for name, (_, radius) in _robot_circles(placed).items()}
        self.agents = Agents(self.engine, self.entities, radii, self._walls, self.seed)
        self.buildings = Buildings(self.world.building, self.engine)
        self.departures = Departures(self.world.extent)
        self.frames = Frames(self.engine, self.robots, self.entities)
        self.strikes = Strikes(self.engine, self.entities, self.robots, self._tick_steps)
        for name, path in self.world.paths.items():
            self.robots[name].mobile.follow_path(path.points, path.speed, self.tick, NO_CLIENT, repeat=path.repeat)
        self.run_data = self._new_run_data({robot.name: robot.pose for robot in placed})
        self.streams.activate_sensors(self.robots)

    def _new_run_data(self, starts: Mapping[str, Pose2]) -> RunData:
        return RunData(
            self.engine,
            self.world,
            self.entities,
            self.robots,
            self.frames,
            self._surface,
            starts,
            self._touched.touches,
            self.tick,
        )

    @property
    def shown_map(self) -> NavigationMap:
        """The map of walls, fixed props and terrain that no robot of the world can pass."""
        return self._surface.common(robot.mobile.declaration for robot in self.robots.values() if robot.drives)

    def travelled(self, robot: str) -> float:
        """Return the distance travelled by a robot's odometry [m]."""
        return self.robot(robot).mobile.odometry.travelled

    def joint_position(self, robot: str, joint: str) -> float:
        """Return the position of a joint of a robot's arm or gripper [rad, m]."""
        return self.robot(robot).arm.position_of(joint)

    def state_of(self, entity: str) -> BodyState | None:
        """Return the state of an entity; None if it is unknown."""
        return self.entities.state(entity) if self.entities.is_known(entity) else None

    def clearance(self, robot: str, other: str) -> Clearance | None:
        """Return the clearance of a robot to another entity, or the nearest; None if one is unknown."""
        clearances = self.run_data.clearances
        if robot not in self.robots or (other and other not in clearances.names):
            return None
        pose = self.frames.true_pose(robot)
        return clearances.between(robot, pose, other) if other else clearances.nearest(robot, pose)

    def localization_error(self, robot: str) -> float | None:
        """Return the distance between a robot's estimated and true position [m]; None without an estimate."""
        estimate = self.robot(robot).mobile.localised_pose() if robot in self.robots else None
        if estimate is None:
            return None
        truth = self.frames.true_pose(robot)
        return estimate.distance(truth.x, truth.y)

    def work(self, robot: str) -> float | None:
        """Return the mechanical work of a robot's motors [J]; None if it is unknown."""
        return self.run_data.work_of(robot)

    def measure_work(self, robot: str) -> None:
        """Measure the work of a robot in each step from now on, if the engine can."""
        if isinstance(self.engine, MeasuresWork) and robot in self.robots:
            self.engine.measure_work(robot)

    def pipeline(self, robot: str, sensor: str) -> SensorPipeline[Any]:
        """Return the pipeline of a robot's sensor.

        Raises:
            RequestRefused: The robot or sensor is unknown.
        """
        sensors = self.robot(robot).sensors
        if sensor not in sensors:
            raise unknown(f"sensor {sensor!r} of {robot}", "sensors", sensors)
        return sensors[sensor]

    def check_camera(self, name: str) -> None:
        """Refuse cameras that are unknown or cannot be rendered; see `Cameras.check`."""
        self.entities.cameras.check(name)

    def picture(self, camera: str) -> Sample[Picture] | None:
        """Return the present picture of a camera; None if it is unknown or gives none."""
        return self.entities.cameras.given(camera, self.tick)

    # ------------------------------------------------------------ time

    @property
    def time(self) -> float:
        """Simulation time [s]; a multiple of the step's length."""
        return (self._steps - self._epoch) / self.engine.steps_per_second

    @property
    def tick(self) -> int:
        """The last tick."""
        return self._steps // self._tick_steps

    def time_of_tick(self, tick: int) -> float:
        """Return the time of a tick [s]."""
        return (tick * self._tick_steps - self._epoch) / self.engine.steps_per_second

    @property
    def is_rendering(self) -> bool:
        """Whether images are rendered while time passes."""
        seen = any(pipeline.is_active for pipeline in self._rendered)
        return seen or self.recording.is_recording or self.entities.cameras.is_busy

    def advance(self, until: float) -> None:
        """Simulate to the first step at or after a time, or to the end of the step with an event.

        An emergency stop, from another thread, also ends it.
        """
        self.run_data.follow_bodies(self.tick)
        while not self.pending and self.time < until and not self.halted.is_set():
            self._advance_to(until)
        for name in self.robots:
            check_state(name, self.engine.body_state(name), self.time)

    def run(self, until: float) -> None:
        """Simulate to the first step at or after a time, regardless of events except an emergency stop."""
        self.run_data.follow_bodies(self.tick)
        while self.time < until and not self.halted.is_set():
            self._advance_to(until)

    def step(self, count: int) -> None:
        """Make physics steps, regardless of events except an emergency stop."""
        self.run_data.follow_bodies(self.tick)
        end = self._steps + count
        while self._steps < end and not self.halted.is_set():
            self._step_to_tick(min(end - self._steps, self._steps_to_tick(1)))

    def _advance_to(self, until: float) -> None:
        """Make the steps to a future time, or to the next tick with something due, if that is earlier."""
        shown = self.is_rendering or self.streams.are_open
        watched = bool(self.watches) or bool(self.camera_faults.goals) or shown
        idle = not (watched or self.agents or self.buildings) and all(map(self._is_at_rest, self.robots.values()))
        count = self._steps_to_tick(IDLE_TICKS if idle else 1)
        made, rate = self._steps - self._epoch, self.engine.steps_per_second
        # Steps that would begin at or after that time are not made.
        if (made + count - 1) / rate >= until:
            count = wire.steps_until(until, rate) - made
        self._step_to_tick(count)

    def _is_at_rest(self, robot: Robot) -> bool:
        """Whether a robot is idle and nothing touches it."""
        return robot.is_idle and not self._touched.touches(robot.name)

    def _steps_to_tick(self, every: int) -> int:
        """Return the number of steps to the next multiple of `every` ticks."""
        steps = every * self._tick_steps
        return steps - self._steps % steps

    def _step_to_tick(self, count: int) -> None:
        """Make steps up to and including the next tick, or fewer on a change of contacts or an emergency stop."""
        self._steps += self._batches.make(self.engine, count, self.halted)
        self._report_contacts()
        if self._touched.touching:
            for name in filter(self._touched.touches, self.robots):
                self.robots[name].update_bumper(math.ceil(self._steps / self._tick_steps))
        if self._steps % self._tick_steps == 0:
            self._tick(self.tick)

    def collect(self) -> list[WorldEvent]:
        """Return the events since the last call."""
        events, self.pending = self.pending, []
        return events

    def _emit(self, event: WorldEvent) -> None:
        self.pending.append(event)
        self.log.add(event)

    def _tick(self, tick: int) -> None:
        self.entities.cameras.tick(tick)
        self._report(self.camera_faults, self.camera_faults.tick(tick))
        self._drive_bodies(tick)
        awake = [robot for robot in self.robots.values() if not tick % IDLE_TICKS or not self._is_at_rest(robot)]
        # People and doors may strike robots at rest.
        sampled = self.robots.values() if self.agents or self.buildings else awake
        self._sample_motion([robot.name for robot in sampled], tick)
        bases = [robot.mobile for robot in awake if robot.drives]
        sense(bases, tick)
        navigated, time = navigate(bases, tick), self.time
        for robot in awake:
            self._report(robot, navigated.get(robot.name, ()))
            self._report(robot, robot.tick(tick))
            self.run_data.record_pose(robot, time, tick)
            self._report_departure(robot.name)
            if robot.drives and (feedback := robot.mobile.feedback_due()) is not None:
                self._emit(feedback_message(robot.name, self.time, feedback))
        at_rest = tick % IDLE_TICKS != 0 and not (awake or self.agents or self.buildings)
        self.run_data.record_positions(tick, at_rest=at_rest)
        self._check_watches()
        self.recording.tick()
        self.streams.tick(self)

    def _drive_bodies(self, tick: int) -> None:
        """Move doors, lifts, people and carts until the next tick."""
        engine, touching = self.engine, self._touched.touching
        if not (self.buildings or self.agents) or not isinstance(engine, DrivesBodies):
            self._report(self.agents, self.agents.tick(tick, touching, NO_POSES))
            return
        poses, first = engine.driven_poses(), len(self.entities.built_in)
        built_in, agents = poses[:first], poses[first:]
        self._report(self.buildings, self.buildings.tick(tick, touching, partial(self._visitors, agents)))
        self._report(self.agents, self.agents.tick(tick, touching, agents))
        (velocities, heights), (others, low) = self.buildings.motion(built_in), self.agents.motion(agents)
        engine.drive_bodies(np.vstack([velocities, others]), np.concatenate([heights, low]))

    def _visitors(self, agents: Array) -> Array:
        """Return the positions of robots, people and carts, shape (n, 2) [m]."""
        robots = [self.engine.body_state(name).position[:2] for name in self.robots]
        return np.vstack([agents[:, :2], np.array(robots).reshape(-1, 2)])

    def connect_outputs(self, streams: Streams, log: EventLog, halted: Event) -> None:
        """Connect streams, log and stop event, also those of an earlier simulation."""
        self.streams, self.log, self.halted = streams, log, halted
        streams.activate_sensors(self.robots)

    def _report_contacts(self) -> None:
        touching = self.engine.touching()
        for first, second in self._touched.update(touching, self._steps):
            if self.strikes.is_on_lift((first, second)):
                continue
            strike = self.strikes.judge_contact((first, second), self._steps, touching)
            self._emit(contact_message(self.time, (first, second), strike))
            self.run_data.record_contact(first, second)

    def _sample_motion(self, robots: Sequence[str], tick: int) -> None:
        """Sample motions, and emit contacts in which a robot begins to push."""
        for name in filter(self._touched.touches, robots) if self._touched.touching else ():
            for pair, strike in self.strikes.judge_push(name, self._touched.touching, tick):
                self._emit(contact_message(self.time, pair, strike, pushes=True))
        if robots:
            self.strikes.sample_motion(robots, tick)

    def _report_departure(self, robot: str) -> None:
        departure = self.departures.find(robot, self.engine.body_state(robot).position, self.time)
        if departure is not None:
            self._emit(departure)

    def move(self, entity: str, state: BodyState) -> None:
        """Set the state of an entity.

        Raises:
            RequestRefused: See `Entities.move`.
        """
        self.entities.move(entity, state)
        self.strikes.on_placed(entity, self._steps)

    # ------------------------------------------------------------ goals

    def robot(self, name: str) -> Robot:
        """Return a robot by name.

        Raises:
            RequestRefused: The robot is unknown.
        """
        if name not in self.robots:
            raise unknown(f"robot {name!r}", "robots", self.robots)
        return self.robots[name]

    def navigate(self, robot: str, goal: Goal) -> None:
        """Start a navigation goal; its result is reported."""
        self._check_unused(goal.id)
        self.robot(robot).mobile.navigate(goal)
        self.strikes.on_command(robot)
        self.run_data.record_goal(robot, goal)

    def drive(self, robot: str, goal: str, velocity: Velocity, duration: float) -> None:
        """Drive a robot with a velocity for a duration [s]; the result is reported."""
        self._check_unused(goal)
        end = self._steps + duration * self.engine.steps_per_second
        last = math.ceil(round(end) / self._tick_steps)
        self.robot(robot).mobile.drive(VelocityCommand(velocity, last, goal))
        self.strikes.on_command(robot)

    def follow_path(
        self, robot: str, goal: str, points: Sequence[tuple[float, float]], speed: float, *, repeat: bool
    ) -> None:
        """Drive a robot along a path by its true pose [m]; the result is reported.

        Raises:
            RequestRefused: The robot cannot, or the path leads through a wall of the map.
        """
        self._check_unused(goal)
        base, here = self.robot(robot).mobile, self.frames.true_pose(robot)
        path = ((here.x, here.y), *points)
        problem = self._walls.describe_block((*path, *(points[:1] if repeat else ())), base.declaration.radius)
        if problem:
            raise operation_failed(problem)
        speed = speed or base.declaration.drive.max_speed
        base.follow_path(path, speed, self.tick, goal, repeat=repeat)
        self.strikes.on_command(robot)

    def command_velocity(self, robot: str, velocity: Velocity) -> None:
        """Command a robot's velocity until the next command, for `COMMAND_TIMEOUT` at most.

        An empty name means the first wheeled robot.
        """
        name = robot or next((other.name for other in self.robots.values() if other.drives), robot)
        base = self.robot(name).mobile
        if not any(base.wheels.applied):  # otherwise the command before continues
            self.strikes.on_command(name)
        base.drive(VelocityCommand(velocity, self.tick + round(COMMAND_TIMEOUT / TICK), None))

    def arm_for_goal(self, robot: str, goal: str) -> Arm:
        """Return the arm of a robot for a goal with an unused id; the result is reported."""
        self._check_unused(goal)
        arm = self.robot(robot).arm
        self.strikes.on_command(robot)
        return arm

    def cancel_goal(self, goal_id: str) -> None:
        """Cancel an active goal by id."""
        active = self._active()
        if goal_id not in active:
            raise RequestRefused(
                wire.Result.NOT_FOUND, f"no active goal {goal_id!r}; active goals: {name_list(active)}"
            )
        self._report(active[goal_id], active[goal_id].cancel(goal_id))

    @property
    def robots_in_use(self) -> frozenset[str]:
        """Names of the robots with a goal or a watch."""
        return self.watches.robots.union(name for name, robot in self.robots.items() if robot.goals)

    def stop_robot(self, robot: str, reason: str = "") -> None:
        """Stop a robot; its goals end as canceled, or as interrupted for a reason."""
        ended = self.robot(robot).stop()
        if reason:
            ended = (replace(end, outcome=wire.Outcome.ABORTED, message=reason, interrupted=True) for end in ended)
        self._report(self.robot(robot), ended)

    def start_motion(self, person: str, motion: Motion, goal: str) -> None:
        """Start a motion of a person or cart; the result is reported."""
        self._check_unused(goal)
        self.agents.start(person, motion, goal, self.tick)

    def stop_person(self, person: str) -> None:
        """Make a person or cart stand; its goal ends as canceled."""
        self._report(self.agents, self.agents.stop(person))

    def move_building(self, name: str, target: float, goal: str) -> None:
        """Move a door to an opening, or a lift to a height [m]; the result is reported."""
        self._check_unused(goal)
        self.buildings.start(name, target, goal, self.tick)

    def inject_fault(self, identifier: str, robot: str, device: str, fault: wire.Fault, limit: float) -> None:
        """Inject a fault into a device; the result of its check, within a limit [s], is reported."""
        self._check_unused(identifier)
        self.faults_of(robot).inject(identifier, device, fault, limit, self.tick)

    def faults_of(self, robot: str) -> FaultRegistry:
        """Return the faults of a robot; an empty name means the free cameras."""
        return self.robot(robot).faults if robot else self.camera_faults

    @property
    def _goal_owners(self) -> tuple[GoalOwner, ...]:
        """Objects that have goals."""
        return (*self.robots.values(), self.camera_faults, self.agents, self.buildings)

    def _active(self) -> dict[str, GoalOwner]:
        """Owners of the active goals by id."""
        return {goal: owner for owner in self._goal_owners for goal in owner.goals}

    def _check_unused(self, identifier: str) -> None:
        """Refuse an id that is in use."""
        if identifier in self._active() or identifier in self.watches:
            raise operation_failed(f"duplicate id {identifier!r}; expected an unused one")

    def _report(self, owner: GoalOwner, ended: Iterable[GoalResult]) -> None:
        for end in ended:
            if end.id == NO_CLIENT:
                continue
            if isinstance(owner, Robot):
                self.run_data.record_result(owner.name, end)
            self._emit_result(end)

    def _emit_result(self, end: GoalResult) -> None:
        self._emit(
            wire.Occurrence(
                id=end.id, time=self.time, outcome=end.outcome, message=end.message, interrupted=end.interrupted
            )
        )

    def measurements(self) -> wire.Measurements:
        """Return the measurements of robots and movable entities since the start of the run."""
        return self.run_data.measurements(self.seed, self.time)

    # ------------------------------------------------------------ watches

    def building_position(self, name: str) -> float | None:
        """Return the opening of a door, or the height of a lift [m]; None if it is unknown."""
        return self.buildings.position(name)

    def pose(self, frame: str) -> Pose2 | None:
        """Return the pose of a frame or body in `map`; None if it is unknown yet."""
        return self.frames.pose(frame)

    def watch(self, identifier: str, watch: Watch) -> None:
        """Report when a condition becomes true; immediately if it is true."""
        self._check_unused(identifier)
        self.watches.add(identifier, watch)
        self._check_watches()

    def _check_watches(self) -> None:
        for end in self.watches.pop_true(self):
            self._emit_result(end)

    # ------------------------------------------------------------ reset

    def reset(self, scope: wire.ResetScope) -> None:
        """Reset the parts that a scope covers; after a full reset, the run repeats identically.

        With `STATE`, goals end as canceled, robots lose their pose, and watches continue. With everything, goals,
        watches and pending events are dropped.
        """
        everything = wire.ResetScope.TIME | wire.ResetScope.STATE | wire.ResetScope.SPAWNED
        if scope == wire.ResetScope.DEFAULT or scope & everything == everything:
            self._start_over()
            return
        if wire.ResetScope.SPAWNED in scope:
            self.entities.delete_all()
        if wire.ResetScope.STATE in scope:
            for robot in self.robots:
                self.stop_robot(robot)
                self._report(self.robots[robot], self.robots[robot].faults.cancel_all())
            for person in self.entities.agents:
                self.stop_person(person)
            self._report(self.buildings, self.buildings.cancel_all())
            self._report(self.camera_faults, self.camera_faults.cancel_all())
            self.engine.reset()
            self.entities.cameras.reset()
            self._touched = Contacts(self.engine.steps_per_second)
            self._make_robots()
            self.watches.carry_over(self)
        if wire.ResetScope.TIME in scope:
            self._epoch = self._steps

    # ------------------------------------------------------------ after restoring a snapshot

    def start_run(self) -> None:
        """Start a run in this state: see `Purpose.BEGIN`."""
        self._epoch = self._steps
        self._detach_goals_except(())
        self.watches = Watches()
        self.pending = []
        self.run_data = self._new_run_data({name: self.frames.true_pose(name) for name in self.robots})
        self.entities.start_run()

    def continue_from(self, before: Simulation) -> None:
        """Continue the run of `before` in this simulation: see `Purpose.REWIND` and `ChangeWorld`."""
        self.recording = before.recording
        self.recording.switch_to(self.world, lambda: self.entities)
        self._epoch = self._steps - (before._steps - before._epoch)
        self.pending = [each for each in before.pending if not isinstance(each, wire.NavigationFeedback)]
        active = before._active()
        kept = self._active().keys() & active.keys()
        self._detach_goals_except(kept)
        for goal, owner in active.items():
            if goal not in kept:
                self._report(owner, [GoalResult(goal, wire.Outcome.CANCELED)])
        self.watches.adopt(before.watches, before, self, self.robots)

    def _detach_goals_except(self, kept: Container[str]) -> None:
        detached = [goal for goal in self._active() if goal not in kept]
        for owner in self._goal_owners:
            owner.detach_goals(detached)


FIXED_RADIUS = 0.3  # [m] about the base of a robot that does not drive


def _robot_circles(robots: Sequence[PlacedRobot]) -> dict[str, tuple[Pose2, float]]:
    """Return the initial poses and radii [m] of robots, as people see them."""
    bases = ((robot, robot.declaration.mobile) for robot in robots)
    return {robot.name: (robot.pose, FIXED_RADIUS if base is None else base.radius) for robot, base in bases}
