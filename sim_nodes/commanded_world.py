"""Commands to robots, people, doors, lifts and devices of a world, and the results of their goals."""

from __future__ import annotations

import math
from collections.abc import Container, Iterable, Sequence
from dataclasses import replace

from seoro.bridges import wire
from seoro.bridges.wire.refusal import RequestRefused, name_list
from sim_nodes.agents.agent import Motion
from sim_nodes.agents.agents import Agents
from sim_nodes.buildings.buildings import Buildings
from sim_nodes.event_log import WorldEvent
from sim_nodes.faults.registry import FaultRegistry
from sim_nodes.manipulation.arm import Arm
from sim_nodes.navigation.goals import Goal
from sim_nodes.outcomes import NO_CLIENT, GoalResult, operation_failed
from sim_nodes.physics import BodyState, MeasuresWork
from sim_nodes.robots.drive import COMMAND_TIMEOUT, VelocityCommand
from sim_nodes.robots.kinematics import Velocity
from sim_nodes.robots.robot import Robot
from sim_nodes.simulated_world import SimulatedWorld
from sim_nodes.ticks import TICK
from sim_nodes.watches import Watch

GoalOwner = Robot | FaultRegistry | Agents | Buildings


class CommandedWorld(SimulatedWorld):
    """A simulated world that accepts commands, and reports the results of goals and watches."""

    def move(self, entity: str, state: BodyState) -> None:
        """Set the state of an entity.

        Raises:
            RequestRefused: See `Entities.move`.
        """
        self.entities.move(entity, state)
        self.strikes.on_placed(entity, self._steps)

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

    def measure_work(self, robot: str) -> None:
        """Measure the work of a robot in each step from now on, if the engine can."""
        if isinstance(self.engine, MeasuresWork) and robot in self.robots:
            self.engine.measure_work(robot)

    def cancel_goal(self, goal_id: str) -> None:
        """Cancel an active goal by id."""
        active = self._active()
        if goal_id not in active:
            raise RequestRefused(
                wire.Result.NOT_FOUND, f"no active goal {goal_id!r}; active goals: {name_list(active)}"
            )
        self._report(active[goal_id], active[goal_id].cancel(goal_id))

    def stop_robot(self, robot: str, reason: str = "") -> None:
        """Stop a robot; its goals end as canceled, or as interrupted for a reason."""
        ended = self.robot(robot).stop()
        if reason:
            ended = (replace(end, outcome=wire.Outcome.ABORTED, message=reason, interrupted=True) for end in ended)
        self._report(self.robot(robot), ended)

    @property
    def robots_in_use(self) -> frozenset[str]:
        """Names of the robots with a goal or a watch."""
        return self.watches.robots.union(name for name, robot in self.robots.items() if robot.goals)

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

    def _detach_goals_except(self, kept: Container[str]) -> None:
        detached = [goal for goal in self._active() if goal not in kept]
        for owner in self._goal_owners:
            owner.detach_goals(detached)

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
                id=end.id,
                time=self.time,
                outcome=end.outcome,
                message=end.message,
                interrupted=end.interrupted,
                margin=end.margin,
            )
        )

    def _emit(self, event: WorldEvent) -> None:
        self.pending.append(event)
        self.log.add(event)

    def watch(self, identifier: str, watch: Watch) -> None:
        """Report when a condition becomes true; immediately if it is true."""
        self._check_unused(identifier)
        self.watches.add(identifier, watch)
        self._check_watches()

    def _check_watches(self) -> None:
        for end in self.watches.pop_true(self):
            self._emit_result(end)
