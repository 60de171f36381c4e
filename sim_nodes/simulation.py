"""One simulated world: time, entities, goals, watches and contacts; independent of engines and Zenoh.

Time is counted in physics steps. Everything else happens in ticks of 20 ms: robots sense and act, watches are
checked. Contacts are detected in the step in which they begin. Events are pending until they are collected.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from threading import Event

import numpy as np

from seoro.bridges import wire
from sim_nodes.commanded_world import CommandedWorld
from sim_nodes.departures import check_state
from sim_nodes.event_log import EventLog, WorldEvent
from sim_nodes.geometry import Array
from sim_nodes.messages import contact_message, feedback_message
from sim_nodes.outcomes import GoalResult
from sim_nodes.robots.fleet import navigate, sense
from sim_nodes.robots.robot import Robot
from sim_nodes.streams import Streams
from sim_nodes.strikes import Contacts
from sim_nodes.ticks import IDLE_TICKS
from sim_nodes.tracks import Tracks
from sim_nodes.watches import Watches

NO_POSES = np.zeros((0, 3))


class Simulation(CommandedWorld):
    """A world in which time passes; see `SimulatedWorld` for its arguments."""

    @property
    def is_rendering(self) -> bool:
        """Whether images are rendered while time passes."""
        seen = any(pipeline.is_active for pipeline in self._rendered)
        return seen or self.recording.is_recording or self.entities.cameras.is_busy

    def advance(self, until: float, *, past_feedback: bool = False) -> None:
        """Simulate to the first step at or after a time, or to the end of the step with an event.

        An emergency stop, from another thread, also ends it.

        Args:
            until: The time [s].
            past_feedback: Whether feedback does not end it.
        """
        self.run_data.follow_bodies(self.tick)
        while self.is_quiet(past_feedback=past_feedback) and self.time < until and not self.halted.is_set():
            self._advance_to(until)
        for name in self.robots:
            check_state(name, self.engine.body_state(name), self.time)

    def is_quiet(self, *, past_feedback: bool) -> bool:
        """Return whether no event is pending, or nothing but feedback that does not count."""
        if not self.pending:
            return True
        return past_feedback and all(isinstance(event, wire.NavigationFeedback) for event in self.pending)

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
        count = self._steps_to_tick(self.tracks.ticks_to_next(self.tick) if idle else 1)
        made, rate = self._steps - self._epoch, self.engine.steps_per_second
        # Steps that would begin at or after that time are not made.
        if (made + count - 1) / rate >= until:
            count = wire.steps_until(until, rate) - made
        self._step_to_tick(count)

    def _is_at_rest(self, robot: Robot) -> bool:
        """Whether a robot is idle and nothing touches it."""
        return robot.is_idle and not self._touched.touches(robot.name)

    def _steps_to_tick(self, ahead: int) -> int:
        """Return the number of steps to the end of the tick that is `ahead` ticks after the last one."""
        return ahead * self._tick_steps - self._steps % self._tick_steps

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

    def drop_feedback(self, until: float) -> None:
        """Drop the pending feedback up to a time [s]."""
        self.pending = [
            event for event in self.pending if not isinstance(event, wire.NavigationFeedback) or event.time > until
        ]

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
            self._report_departure(robot.name)
            if robot.drives and (feedback := robot.mobile.feedback_due()) is not None:
                self._emit(feedback_message(robot.name, self.time, feedback))
        self.run_data.record_poses(awake, time, tick)
        at_rest = tick % IDLE_TICKS != 0 and not (awake or self.agents or self.buildings)
        self.run_data.record_positions(tick, at_rest=at_rest)
        self._check_watches()
        self.recording.tick()
        self.streams.tick(self)
        if self.tracks.is_due(tick):
            self.sample_tracks()

    def sample_tracks(self) -> None:
        """Add a sample to the tracks, if they are wanted."""
        self.tracks.sample(self.time, self.tick, self.engine, self.robots, self.entities)

    def _drive_bodies(self, tick: int) -> None:
        """Move doors, lifts, people and carts until the next tick."""
        engine, touching = self._driving_engine, self._touched.touching
        if engine is None or not (self.buildings or self.agents):
            self._report(self.agents, self.agents.tick(tick, touching, NO_POSES))
            return
        poses, first = engine.driven_poses(), len(self.entities.built_in)
        built_in, agents = poses[:first], poses[first:]
        if self.buildings:
            self._report(self.buildings, self.buildings.tick(tick, touching, partial(self._visitors, agents)))
        self._report(self.agents, self.agents.tick(tick, touching, agents))
        velocities, heights = self.agents.motion(agents)
        if self.buildings:
            moves, levels = self.buildings.motion(built_in)
            velocities, heights = np.vstack([moves, velocities]), np.concatenate([levels, heights])
        engine.drive_bodies(velocities, heights)

    def _visitors(self, agents: Array) -> Array:
        """Return the positions of robots, people and carts, shape (n, 2) [m]."""
        robots = [self.engine.body_state(name).position[:2] for name in self.robots]
        return np.vstack([agents[:, :2], np.array(robots).reshape(-1, 2)])

    def connect_outputs(self, streams: Streams, log: EventLog, tracks: Tracks, halted: Event) -> None:
        """Connect streams, log, tracks and stop event, also those of an earlier simulation."""
        self.streams, self.log, self.tracks, self.halted = streams, log, tracks, halted
        tracks.continue_in(self.world, self.describe_scene)
        self.sample_tracks()
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
