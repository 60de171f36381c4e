"""The arm of a robot: what it is asked for is planned and checked at once, and carried out in ticks."""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from seoro.bridges.wire import Outcome, Result
from seoro.bridges.wire.refusal import RequestRefused, listed
from sim_nodes.geometry import Array, rotation_matrix
from sim_nodes.goals import NOBODY, Ended
from sim_nodes.manipulation.chain import inverse, pose_matrix
from sim_nodes.manipulation.gripper import Gripper, HoldGoal
from sim_nodes.manipulation.links import joint_counts
from sim_nodes.manipulation.motion import Course, Motion
from sim_nodes.manipulation.planner import Circumstances, Load, Planner, check_count
from sim_nodes.manipulation.servos import Servos
from sim_nodes.manipulation.trajectory import Path
from sim_nodes.physics import Engine, JointStates, PlacedRobot
from sim_nodes.robots.declaration import ArmDeclaration
from sim_nodes.stateful import Stateful
from sim_nodes.ticks import TICK

MAX_WAYPOINTS = 1000
BASE_FRAME = "base_link"


@dataclass(frozen=True)
class Manner:
    """How an arm is to move.

    Args:
        scaling: Part of the speed of its joints that it may use, up to 1.
        tolerance: How near the joints have to come to their goal [rad].
        may_touch: Entities that it may collide with.
        plan_only: Whether to find and check a path without moving.
    """

    scaling: float = 1.0
    tolerance: float = 1e-3
    may_touch: frozenset[str] = frozenset()
    plan_only: bool = False


class Arm(Stateful):
    """An arm with a gripper.

    Args:
        placed: The robot that has it.
        declaration: What is declared of it.
        engine: The engine that it is in.
        seed: Seed of the simulation.
        is_loose: Says whether an entity can be carried.
    """

    STATE = ("_motion", "gripper", "servos", "_planned")

    def __init__(
        self,
        placed: PlacedRobot,
        declaration: ArmDeclaration,
        engine: Engine,
        seed: int,
        is_loose: Callable[[str], bool],
    ) -> None:
        self._robot, self._engine = placed.name, engine
        self._planner = Planner(placed, declaration, engine)
        self._chain = self._planner.chain
        self._acceleration = np.array([joint.max_acceleration for joint in declaration.joints])
        self.gripper = Gripper(placed.name, declaration.gripper, engine, is_loose)
        self.joints = (*self._chain.joints, *declaration.gripper.joints)
        self._depths = joint_counts(placed.declaration.urdf, self._chain.joints)
        self._fingers = declaration.gripper.links
        self._motion = Motion(self._chain.joints)
        self.servos = Servos(placed.name, len(self._chain.joints), engine)
        self._planned: list[str] = []  # goals that end with the next tick, because nothing is to be moved

    # ------------------------------------------------------------ state

    @property
    def goals(self) -> tuple[str, ...]:
        """The ids of the goals that it is working on, for somebody."""
        motion, gripping = self._motion.goal, self.gripper.goal
        goals = (motion, None if gripping is None else gripping.id)
        watching = (hold.id for hold in self.gripper.holds)
        return (*(goal for goal in goals if goal not in (None, NOBODY)), *watching, *self._planned)

    @property
    def is_idle(self) -> bool:
        """Whether it has nothing to do and nothing to watch."""
        return self._motion.course is None and not self.gripper.is_busy and not self._planned

    @property
    def remaining(self) -> float:
        """How long its motion goes on [s]."""
        return self._motion.remaining

    def states(self) -> JointStates:
        """Its joints, and the fingers."""
        return self._engine.joint_states(self._robot)

    def position_of(self, joint: str) -> float:
        """The position of a joint or finger by its name [rad, m].

        Raises:
            RequestRefused: There is no such joint.
        """
        if joint not in self.joints:
            raise RequestRefused(
                Result.NOT_FOUND, f"{self._robot} has no joint {joint!r}: known are {listed(self.joints)}"
            )
        return float(self.states().positions[self.joints.index(joint)])

    def velocity_at(
        self, link: str, point: Sequence[float], joints: Sequence[float], rates: Sequence[float]
    ) -> Array:
        """The velocity in the map of a point of a link, by the joints of the arm and of the gripper [m/s].

        Args:
            link: Name of the link.
            point: In the map [m].
            joints: Positions of the arm's joints and the fingers [rad, m].
            rates: Of the same [rad/s, m/s].
        """
        count = self._depths.get(link, 0)
        in_map = self._planner.pose_base_in_map
        place = (inverse(in_map) @ (*point, 1.0))[:3]
        velocity = self._chain.velocity_at(np.array(joints), np.array(rates), count, place)
        turned: Array = in_map[:3, :3] @ velocity
        if link not in self._fingers:
            return turned
        return turned + rates[len(self._chain.joints) + self._fingers.index(link)] * self._outward(link)

    def _outward(self, finger: str) -> Array:
        """The direction in which a finger slides when the gripper opens, in the map; zero where both meet."""
        here, there = (
            np.array(self._engine.link_pose(self._robot, link)[0])
            for link in (finger, *(other for other in self._fingers if other != finger))
        )
        apart: Array = here - there
        length = float(np.linalg.norm(apart))
        return apart / length if length > 0.0 else apart

    def tool_pose(self) -> Array:
        """The pose of the tool in the map, shape (4, 4)."""
        return self._planner.pose_base_in_map @ self._chain.tool_pose(self._configuration())

    def in_map(self, pose: Array, frame: str) -> Array:
        """A pose given in a frame, `map` or that of the arm's base, in the map.

        Raises:
            RequestRefused: There is no such frame.
        """
        if frame == "map":
            return pose
        known = (BASE_FRAME, f"{self._robot}/{BASE_FRAME}")
        if frame not in known:
            raise RequestRefused(
                Result.NOT_FOUND,
                f"poses of {self._robot} are in one of {listed(('map', *known))}, not in {frame!r}",
            )
        return self._planner.pose_base_in_map @ pose

    def _configuration(self) -> Array:
        return self.states().positions[: len(self._chain.joints)]

    # ------------------------------------------------------------ goals

    def follow(
        self, goal: str, configurations: Sequence[Sequence[float]], names: Sequence[str], manner: Manner
    ) -> None:
        """Move the joints through configurations [rad], in the order of some names, or that of the arm.

        Raises:
            RequestRefused: Busy, or the planner refuses; the same holds for the other motions.
        """
        if not 1 <= len(configurations) <= MAX_WAYPOINTS:
            raise RequestRefused(
                Result.OPERATION_FAILED, f"{len(configurations)} points were given: give 1 to {MAX_WAYPOINTS}"
            )
        order = self._order(names)
        for positions in configurations:
            check_count(self._robot, names or self._chain.joints, positions)
        points = [np.array(positions, dtype=np.float64)[order] for positions in configurations]
        self._start(goal, manner, lambda now: self._planner.through(now, points))

    def move_to_pose(self, goal: str, target: Array, manner: Manner) -> None:
        """Move the tool to a pose in the map, shape (4, 4), on whatever way all joints move evenly."""
        self._start(goal, manner, lambda now: self._planner.to_pose(now, target))

    def move_straight(self, goal: str, target: Array, manner: Manner) -> None:
        """Move the tool to a pose in the map, shape (4, 4), in a straight line."""
        self._start(goal, manner, lambda now: self._planner.straight(now, target))

    def hold(self, goal: str, entity: str, duration: float, tick: int) -> None:
        """Report whether an entity stays held for a duration [s]; an empty name is what is held now.

        Raises:
            RequestRefused: It is not held.
        """
        held = self.gripper.check_hold(entity)
        self.gripper.holds.append(HoldGoal(goal, held, tick + math.ceil(duration / TICK - 1e-9)))

    def _start(self, goal: str, manner: Manner, plan: Callable[[Circumstances], Path]) -> None:
        if self._motion.goal not in (None, NOBODY):
            raise RequestRefused(
                Result.INCORRECT_STATE,
                f"{self._robot} moves for goal {self._motion.goal!r}: cancel it, or wait for its end",
            )
        start = self._configuration()
        path = plan(Circumstances(start, self._load(start), manner.may_touch))
        if manner.plan_only:
            self._planned.append(goal)
            return
        speed = manner.scaling * self._chain.limits.speed
        self._motion.follow(Course(goal, manner.tolerance, path.points, speed, self._acceleration))

    def _order(self, names: Sequence[str]) -> list[int]:
        """Where the positions of the joints are in what is given in the order of some names."""
        joints = self._chain.joints
        if names and sorted(names) != sorted(joints):
            raise RequestRefused(
                Result.OPERATION_FAILED,
                f"the joints of {self._robot} are {', '.join(joints)}, not {', '.join(names)}",
            )
        return [(names or joints).index(joint) for joint in joints]

    def _load(self, configuration: Array) -> Load | None:
        held = self.gripper.held
        if held is None:
            return None
        state = self._engine.body_state(held)
        tool = self._planner.pose_base_in_map @ self._chain.tool_pose(configuration)
        pose = pose_matrix(state.position, rotation_matrix(state.orientation))
        return Load(held, inverse(tool) @ pose)

    # ------------------------------------------------------------ ticks

    def tick(self, tick: int) -> Iterator[Ended]:
        """Do what is due in a tick; gives the goals that ended."""
        for goal in self._planned:
            yield Ended(goal, Outcome.SUCCEEDED)
        self._planned = []
        self.servos.wanted = self.gripper.wanted = 0.0
        if self.is_idle:
            return
        states = self.states()
        yield from self._move(states)
        yield from self.gripper.tick(states, tick)

    def _move(self, states: JointStates) -> Iterator[Ended]:
        moment, ended = self._motion.tick(states)
        if moment is not None:
            self.servos.pull(moment)
        if ended is not None:
            yield self._explained(ended)

    def _explained(self, ended: Ended) -> Ended:
        """What has ended, with what the arm touches if that may be the reason."""
        if ended.outcome is not Outcome.ABORTED:
            return ended
        touched = sorted(self._engine.link_contacts(self._robot))
        against = [f"{link} touches {other!r}" for link, other in touched if other != self.gripper.held]
        message = f"{ended.message}; {', '.join(against)}" if against else ended.message
        return Ended(ended.id, ended.outcome, f"{self._robot}: {message}")

    def cancel(self, goal: str) -> Iterator[Ended]:
        """Cancel a goal; an arm that moves comes to rest on its path."""
        if goal not in self.goals:
            return
        if self._motion.goal == goal:
            self._motion.brake()
        if self.gripper.goal is not None and self.gripper.goal.id == goal:
            self.gripper.stop()
        self.gripper.holds = [hold for hold in self.gripper.holds if hold.id != goal]
        self._planned = [planned for planned in self._planned if planned != goal]
        yield Ended(goal, Outcome.CANCELED)

    def disown(self, goals: Container[str]) -> None:
        """See `Robot.disown`."""
        if self._motion.goal is not None and self._motion.goal in goals:
            self._motion.rename(NOBODY)
        self.gripper.disown(goals)
        self._planned = [planned for planned in self._planned if planned not in goals]

    def stop(self) -> Iterator[Ended]:
        """Cancel everything; what is held stays held."""
        for goal in self.goals:
            yield from self.cancel(goal)
        self._motion.brake()
        self.gripper.stop()
