"""One simulated world: time, entities, goals, watches and contacts. It knows neither an engine nor Zenoh.

Time is counted in physics steps. Everything besides physics happens in ticks of 20 ms: robots sense and act,
watches are checked. Contacts are noticed in the step in which they begin. What happens is held until it is
collected.
"""

from __future__ import annotations

import math
from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import replace
from threading import Event
from typing import Any

from seoro.bridges.wire import (
    Fault,
    Measurements,
    NavigationFeedback,
    Occurrence,
    Outcome,
    ResetScope,
    Result,
    steps_until,
)
from seoro.bridges.wire.refusal import RequestRefused, listed
from sim_nodes.batches import Batches
from sim_nodes.contacts import Contacts
from sim_nodes.departures import Departures, check_state
from sim_nodes.entities import Entities
from sim_nodes.faults.board import FaultBoard
from sim_nodes.faults.cameras import FreeCameras
from sim_nodes.films import Films
from sim_nodes.frames import Frames
from sim_nodes.geometry import Pose2
from sim_nodes.goals import NOBODY, Ended
from sim_nodes.happenings import Happened, Log, Pending, What
from sim_nodes.manipulation.arm import Arm
from sim_nodes.messages import contact_message, feedback_message
from sim_nodes.navigation.mapping import build_map
from sim_nodes.navigation.navigator import Goal
from sim_nodes.notes import Notes
from sim_nodes.physics import BodyState, Engine
from sim_nodes.robots.diff_drive import Velocity
from sim_nodes.robots.robot import Knowledge, Robot
from sim_nodes.sensors.feed import Feed
from sim_nodes.stateful import Stateful
from sim_nodes.streams import Streams
from sim_nodes.strikes import Strikes
from sim_nodes.ticks import IDLE_TICKS, TICK
from sim_nodes.watches import Watch, Watches
from sim_nodes.worlds.loader import World


class Simulation(Stateful):
    """A world in an engine.

    Args:
        engine: The engine; whatever is in it is replaced.
        world: The world.
        seed: All randomness follows from it.
    """

    STATE = (
        "_steps",
        "_epoch",
        "_watches",
        "_touched",
        "strikes",
        "departures",
        "entities",
        "camera_faults",
        "robots",
        "notes",
        "_pending",
    )

    DERIVED = ("streams", "log", "halted", "_batches")  # the simulator's, and the machine's

    def __init__(self, engine: Engine, world: World, seed: int) -> None:
        self.engine = engine
        self.world = world
        self.seed = seed
        self.known = build_map(world.extent, world.walls, world.outlines)
        self._tick_steps = round(TICK * engine.steps_per_second)
        self.films = Films(engine, world, lambda: self.entities)
        self.streams = Streams()
        self.log = Log()
        self.halted = Event()
        self._batches = Batches()
        self._start_over()

    def _start_over(self) -> None:
        self.engine.build(self.world.scene)
        self._steps = 0
        self._epoch = 0  # step at which the clock shows zero
        self._watches = Watches()
        self._touched = Contacts(self.engine.steps_per_second)
        self.entities = Entities(self.engine, self.world, self.seed)
        self._make_robots()
        self._pending = Pending()

    def _make_robots(self) -> None:
        placed = self.world.robots
        cameras = self.entities.cameras
        self.camera_faults = FaultBoard("", FreeCameras(cameras))
        about = Knowledge(self.known, self.entities.is_loose, cameras)
        self.robots = {robot.name: Robot(robot, self.engine, about, self.seed) for robot in placed}
        self.departures = Departures(self.world.extent)
        self.frames = Frames(self.engine, self.robots, self.entities)
        self.strikes = Strikes(self.engine, self.entities, self.robots, self._tick_steps)
        self.notes = self._new_notes({robot.name: robot.pose for robot in placed})
        self.streams.use(self.robots)

    def _new_notes(self, starts: Mapping[str, Pose2]) -> Notes:
        return Notes(self.engine, self.world, self.entities, self.robots, self.frames, starts)

    def travelled(self, robot: str) -> float:
        """What the odometry of a robot has counted [m]."""
        return self.robot(robot).mobile.odometry.travelled

    def joint_position(self, robot: str, joint: str) -> float:
        """Where a joint of a robot's arm or gripper is [rad, m]."""
        return self.robot(robot).arm.position_of(joint)

    def feed(self, robot: str, sensor: str) -> Feed[Any]:
        """The way of the samples of a robot's sensor.

        Raises:
            RequestRefused: There is no such robot, or it has no such sensor.
        """
        sensors = self.robot(robot).sensors
        if sensor not in sensors:
            raise RequestRefused(Result.NOT_FOUND, f"{robot} has no sensor {sensor!r}: it has {listed(sensors)}")
        return sensors[sensor]

    def true_pose(self, robot: str) -> Pose2:
        """Where a robot really is."""
        return self.frames.true_pose(robot)

    # ------------------------------------------------------------ time

    @property
    def time(self) -> float:
        """The clock [s]; a multiple of the step's length."""
        return (self._steps - self._epoch) / self.engine.steps_per_second

    @property
    def tick(self) -> int:
        """The last tick."""
        return self._steps // self._tick_steps

    def time_of_tick(self, tick: int) -> float:
        """The time of a tick [s]."""
        return (tick * self._tick_steps - self._epoch) / self.engine.steps_per_second

    @property
    def draws(self) -> bool:
        """Whether pictures are taken while time passes."""
        return self.films.is_recording or self.entities.cameras.is_busy

    @property
    def has_to_tell(self) -> bool:
        """Whether something has happened that was not collected yet."""
        return bool(self._pending)

    def advance(self, until: float) -> None:
        """Simulate to the first step at or after a time, or to the end of the step in which something happened.

        An emergency stop, which another thread hears of, ends it, too.
        """
        while not self.has_to_tell and self.time < until and not self.halted.is_set():
            self._pass(until)
        self._check_states()

    def _check_states(self) -> None:
        """Check that the physics has kept the robots near the floor, at finite states."""
        for name in self.robots:
            check_state(name, self.engine.body_state(name), self.time)

    def run(self, until: float) -> None:
        """Simulate to the first step at or after a time, whatever happens but an emergency stop."""
        while self.time < until and not self.halted.is_set():
            self._pass(until)

    def step(self, count: int) -> None:
        """Make physics steps, whatever happens but an emergency stop."""
        end = self._steps + count
        while self._steps < end and not self.halted.is_set():
            self._make(min(end - self._steps, self._steps_to_tick(1)))

    def _pass(self, until: float) -> None:
        """Make the steps to a time that has not come, or to the next tick in which something is due, if before."""
        shown = self.draws or self.streams.are_open
        watched = bool(self._watches) or bool(self.camera_faults.goals) or shown
        idle = not watched and all(map(self._rests, self.robots.values()))
        count = self._steps_to_tick(IDLE_TICKS if idle else 1)
        made, rate = self._steps - self._epoch, self.engine.steps_per_second
        # No step is made that begins at that time or after it.
        if (made + count - 1) / rate >= until:
            count = steps_until(until, rate) - made
        self._make(count)

    def _rests(self, robot: Robot) -> bool:
        """Whether a robot has nothing to do, and nothing pushes it about."""
        return robot.is_idle and not self._touched.touches(robot.name)

    def _steps_to_tick(self, every: int) -> int:
        """Steps to the next tick of those that come once in `every`."""
        steps = every * self._tick_steps
        return steps - self._steps % steps

    def _make(self, count: int) -> None:
        """Make steps up to the next tick and that, or fewer, to a change of what touches or an emergency stop."""
        self._steps += self._batches.make(self.engine, count, self.halted)
        self._note_contacts()
        for name in filter(self._touched.touches, self.robots):
            self.robots[name].touch(math.ceil(self._steps / self._tick_steps))
        if self._steps % self._tick_steps == 0:
            self._tick(self.tick)

    def collect(self) -> Happened:
        """What has happened since this was last asked."""
        return self._pending.take()

    def _happen(self, what: What) -> None:
        self._pending.add(what)
        self.log.add(what)

    def _tick(self, tick: int) -> None:
        self.entities.cameras.tick(tick)
        self._report(self.camera_faults, self.camera_faults.tick(tick))
        awake = [robot for robot in self.robots.values() if not tick % IDLE_TICKS or not self._rests(robot)]
        self._note_motion([robot.name for robot in awake], tick)
        for robot in awake:
            self._report(robot, robot.tick(tick))
            self.notes.passed(robot, self.time, tick)
            self._note_departure(robot.name)
            if robot.drives and (feedback := robot.mobile.feedback_due()) is not None:
                self._happen(feedback_message(robot.name, self.time, feedback))
        self.notes.note_places(tick)
        self._check_watches()
        self.films.tick()
        self.streams.tick(self)

    def tell(self, streams: Streams, log: Log, halted: Event) -> None:
        """Tell by these, which another simulation may have told by, and stop when it is halted."""
        self.streams, self.log, self.halted = streams, log, halted
        streams.use(self.robots)

    def _note_contacts(self) -> None:
        touching = self.engine.touching()
        for first, second in self._touched.note(touching, self._steps):
            strike = self.strikes.begins((first, second), self._steps, touching)
            self._happen(contact_message(self.time, (first, second), strike))
            self.notes.touched(first, second)

    def _note_motion(self, robots: Sequence[str], tick: int) -> None:
        """Note how things move, and which robots begin to push what they touch."""
        for name in filter(self._touched.touches, robots):
            for pair, strike in self.strikes.pushes(name, self._touched.touching, tick):
                self._happen(contact_message(self.time, pair, strike, pushes=True))
        if robots:
            self.strikes.sample(robots, tick)

    def _note_departure(self, robot: str) -> None:
        departure = self.departures.find(robot, self.engine.body_state(robot).position, self.time)
        if departure is not None:
            self._happen(departure)

    def move(self, entity: str, state: BodyState) -> None:
        """Put an entity somewhere.

        Raises:
            RequestRefused: See `Entities.move`.
        """
        self.entities.move(entity, state)
        self.strikes.placed(entity, self._steps)

    # ------------------------------------------------------------ goals

    def robot(self, name: str) -> Robot:
        """A robot by name.

        Raises:
            RequestRefused: There is none.
        """
        if name not in self.robots:
            raise RequestRefused(Result.NOT_FOUND, f"there is no robot {name!r}: known are {listed(self.robots)}")
        return self.robots[name]

    def set_initial_pose(self, robot: str, pose: Pose2) -> None:
        """Tell the localisation of a robot where it is."""
        self.robot(robot).mobile.set_initial_pose(pose, self.tick)

    def search_pose(self, robot: str) -> None:
        """Have a robot forget where it is, and look for itself on the whole map."""
        self.robot(robot).mobile.search_pose(self.tick)

    def navigate(self, robot: str, goal: Goal) -> None:
        """Send a robot to a goal; its end is reported."""
        self._claim(goal.id)
        self.robot(robot).mobile.navigate(goal)
        self.strikes.commanded(robot)
        self.notes.sent(robot, goal)

    def drive(self, robot: str, goal: str, velocity: Velocity, duration: float) -> None:
        """Drive a robot with a velocity for a duration [s]; its end is reported."""
        self._claim(goal)
        end = self._steps + duration * self.engine.steps_per_second
        self.robot(robot).mobile.drive(goal, velocity, math.ceil(round(end) / self._tick_steps))
        self.strikes.commanded(robot)

    def command_velocity(self, robot: str, velocity: Velocity) -> None:
        """Command a robot's velocity; no name is the first robot that drives."""
        name = robot or next((other.name for other in self.robots.values() if other.drives), robot)
        base = self.robot(name).mobile
        if not any(base.wheels.told):  # else the command before goes on
            self.strikes.commanded(name)
        base.command(velocity, self.tick)

    def feedback(self, robot: str) -> NavigationFeedback:
        """How far a robot is on its way."""
        return feedback_message(robot, self.time, self.robot(robot).mobile.feedback())

    def arm_of(self, robot: str, goal: str) -> Arm:
        """The arm of a robot, to be given a goal by an id that is not in use; its end is reported."""
        self._claim(goal)
        arm = self.robot(robot).arm
        self.strikes.commanded(robot)
        return arm

    def hold_entity(self, robot: str, goal: str, entity: str, duration: float) -> None:
        """Report whether a gripper holds an entity for a duration [s]; an empty name is what it holds."""
        self.arm_of(robot, goal).hold(goal, entity, duration, self._steps // self._tick_steps)

    def cancel_goal(self, goal_id: str) -> None:
        """Cancel an active goal by id."""
        active = self._active()
        if goal_id not in active:
            raise RequestRefused(
                Result.NOT_FOUND, f"there is no active goal {goal_id!r}: active are {listed(active)}"
            )
        self._report(active[goal_id], active[goal_id].cancel(goal_id))

    @property
    def in_use(self) -> frozenset[str]:
        """Names of the robots that have a goal, or that something is watched of."""
        return self._watches.robots.union(name for name, robot in self.robots.items() if robot.goals)

    def stop_robot(self, robot: str, reason: str = "") -> None:
        """Stop a robot; the goals that it had end as canceled, or as interrupted for a reason."""
        ended = self.robot(robot).stop()
        if reason:
            ended = (replace(end, outcome=Outcome.ABORTED, message=reason, interrupted=True) for end in ended)
        self._report(self.robot(robot), ended)

    def inject_fault(self, identifier: str, robot: str, device: str, fault: Fault, limit: float) -> None:
        """Inject a fault into a device; the end of its measurement, within a limit [s], is reported."""
        self._claim(identifier)
        self.faults_of(robot).inject(identifier, device, fault, limit, self.tick)

    def faults_of(self, robot: str) -> FaultBoard:
        """The faults of a robot, or, without a name, of the free cameras."""
        return self.robot(robot).faults if robot else self.camera_faults

    @property
    def _workers(self) -> tuple[Robot | FaultBoard, ...]:
        """All that works on goals."""
        return (*self.robots.values(), self.camera_faults)

    def _active(self) -> dict[str, Robot | FaultBoard]:
        """Who works on which goal, by the goals' ids."""
        return {goal: who for who in self._workers for goal in who.goals}

    def _claim(self, identifier: str) -> None:
        """Refuse an id that is in use."""
        if identifier in self._active() or identifier in self._watches:
            raise RequestRefused(
                Result.OPERATION_FAILED, f"the id {identifier!r} is in use: give each goal its own"
            )

    def _report(self, who: Robot | FaultBoard, ended: Iterable[Ended]) -> None:
        for end in ended:
            if end.id == NOBODY:
                continue
            if isinstance(who, Robot):
                self.notes.ended(who.name, end)
            self._tell_end(end)

    def _tell_end(self, end: Ended) -> None:
        self._happen(
            Occurrence(
                id=end.id,
                time=self.time,
                outcome=end.outcome,
                message=end.message,
                interrupted=end.interrupted,
            )
        )

    def measurements(self) -> Measurements:
        """What was measured of the robots that drive, since they were put there."""
        return self.notes.measurements(self.seed, self.time)

    # ------------------------------------------------------------ watches

    def pose(self, frame: str) -> Pose2 | None:
        """The pose of a frame or a body in the map; None when it has none."""
        return self.frames.pose(frame)

    def cancel_watch(self, identifier: str) -> None:
        """Forget a watch."""
        self._watches.cancel(identifier)

    def forget_watches(self, prefix: str) -> None:
        """Forget all watches whose ids begin so."""
        self._watches.forget(prefix)

    def watch(self, identifier: str, watch: Watch) -> None:
        """Report when a condition becomes true; at once if it is true already."""
        self._claim(identifier)
        self._watches.add(identifier, watch)
        self._check_watches()

    def _check_watches(self) -> None:
        for end in self._watches.take_true(self):
            self._tell_end(end)

    # ------------------------------------------------------------ reset

    def reset(self, scope: ResetScope) -> None:
        """Reset what a scope covers; with everything, the run starts over and is the same again.

        With `STATE` goals end as canceled, robots are unlocalised again and watches wait on; with everything,
        goals, watches and what was pending are forgotten.
        """
        everything = ResetScope.TIME | ResetScope.STATE | ResetScope.SPAWNED
        if scope == ResetScope.DEFAULT or scope & everything == everything:
            self._start_over()
            return
        if ResetScope.SPAWNED in scope:
            self.entities.delete_all()
        if ResetScope.STATE in scope:
            for robot in self.robots:
                self.stop_robot(robot)
                self._report(self.robots[robot], self.robots[robot].faults.abandon())
            self._report(self.camera_faults, self.camera_faults.abandon())
            self.engine.reset()
            self.entities.cameras.reset()
            self._touched = Contacts(self.engine.steps_per_second)
            self._make_robots()
            self._watches.carry_over(self)
        if ResetScope.TIME in scope:
            self._epoch = self._steps

    # ------------------------------------------------------------ after a snapshot was restored

    def begin(self) -> None:
        """Be the beginning of a run: see `Purpose.BEGIN`."""
        self._epoch = self._steps
        self._disown_all_but(())
        self._watches = Watches()
        self._pending = Pending()
        self.notes = self._new_notes({name: self.true_pose(name) for name in self.robots})
        self.entities.begin()

    def take_over(self, before: Simulation) -> None:
        """Be what a run goes on in that has come to `before`: see `Purpose.REWIND`, and `ChangeWorld`."""
        self.films = before.films
        self.films.go_on_in(self.world, lambda: self.entities)
        self._epoch = self._steps - (before._steps - before._epoch)
        self._pending = before._pending.without_feedback()
        active = before._active()
        kept = self._active().keys() & active.keys()
        self._disown_all_but(kept)
        for goal, who in active.items():
            if goal not in kept:
                self._report(who, [Ended(goal, Outcome.CANCELED)])
        self._watches.take_over(before._watches, before, self, self.robots)

    def _disown_all_but(self, kept: Container[str]) -> None:
        gone = [goal for goal in self._active() if goal not in kept]
        for who in self._workers:
            who.disown(gone)
