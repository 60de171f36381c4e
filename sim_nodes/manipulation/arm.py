"""Arm of a robot: goals are planned and checked when they are accepted, and executed in ticks."""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterator, Sequence

import numpy as np

from seoro.bridges.wire import Outcome
from seoro.deferred import dataclass
from sim_nodes.geometry import Array, rotation_matrix
from sim_nodes.manipulation.chain import inverse, pose_matrix
from sim_nodes.manipulation.gripper import Gripper, HoldGoal
from sim_nodes.manipulation.motion import JointMotion, Motion, Path
from sim_nodes.manipulation.moved_links import MovedLinks, base_in_map
from sim_nodes.manipulation.planner import AttachedObject, Planner, PlanningScene, check_count, make_planner
from sim_nodes.manipulation.servos import Servos
from sim_nodes.outcomes import (
    NO_CLIENT,
    GoalResult,
    feature_unsupported,
    incorrect_state,
    operation_failed,
    unknown,
)
from sim_nodes.physics import Engine, JointStates, PlacedRobot
from sim_nodes.robots.declaration import ArmDeclaration
from sim_nodes.stateful import Stateful
from sim_nodes.ticks import TICK

MAX_WAYPOINTS = 1000
BASE_FRAME = "base_link"


@dataclass(frozen=True)
class MotionOptions:
    """Parameters of an arm motion.

    Args:
        scaling: Share of the joints' speed limits, up to 1.
        tolerance: Maximum distance of each joint from its goal [rad], [m].
        may_touch: Entities that the arm may collide with.
        plan_only: Whether to plan and check a path without moving.
    """

    scaling: float = 1.0
    tolerance: float = 1e-3
    may_touch: frozenset[str] = frozenset()
    plan_only: bool = False


class Arm(Stateful):
    """Position-controlled joints: an arm, perhaps with a gripper, or those of a body such as one with legs.

    Args:
        placed: Robot that has the arm.
        declaration: Declaration of the arm.
        engine: Engine that simulates it.
        is_movable: Returns whether an entity can be carried.
    """

    STATE = ("_motion", "_gripper", "servos", "_planned", "_posture")

    def __init__(
        self,
        placed: PlacedRobot,
        declaration: ArmDeclaration,
        engine: Engine,
        is_movable: Callable[[str], bool],
    ) -> None:
        self._robot, self._engine = placed.name, engine
        self._postures = {posture.name: posture for posture in placed.declaration.postures}
        self._planner = make_planner(placed, declaration, engine)
        self._acceleration = np.array([joint.max_acceleration for joint in declaration.joints])
        gripper = declaration.gripper
        self._gripper = None if gripper is None else Gripper(placed.name, gripper, engine, is_movable)
        self.joints = (*self._planner.joints, *declaration.fingers)
        self._moved = MovedLinks(placed.declaration, self._planner.joints)
        self._fingers = declaration.finger_links
        stands = declaration.tool_link is None
        self._motion = Motion(self._planner.joints, self._planner.limits.units, stands=stands)
        self.servos = Servos(placed.name, len(self._planner.joints), engine)
        # Positions of the last goal, or at the start; None after a motion that did not reach its goal.
        self._posture: Array | None = np.array([joint.home for joint in declaration.joints])
        self._planned: list[str] = []  # goals that end in the next tick without a motion

    # ------------------------------------------------------------ state

    @property
    def has_gripper(self) -> bool:
        """Whether it has a gripper."""
        return self._gripper is not None

    @property
    def gripper(self) -> Gripper:
        """The gripper.

        Raises:
            RequestRefused: The robot lacks one.
        """
        if self._gripper is None:
            raise feature_unsupported(f"{self._robot} has no gripper")
        return self._gripper

    @property
    def held(self) -> str | None:
        """Entity held by the gripper, if any."""
        return None if self._gripper is None else self._gripper.held

    @property
    def _tool(self) -> Planner:
        """The planner of the tool.

        Raises:
            RequestRefused: The robot lacks a tool.
        """
        if not isinstance(self._planner, Planner):
            raise feature_unsupported(f"{self._robot} has no tool: its joints follow joint trajectories only")
        return self._planner

    @property
    def goals(self) -> tuple[str, ...]:
        """Ids of active goals that a client waits for."""
        motion, gripping = self._motion.goal, None if self._gripper is None else self._gripper.goal
        goals = (motion, None if gripping is None else gripping.id)
        watching = () if self._gripper is None else (hold.id for hold in self._gripper.holds)
        return (*(goal for goal in goals if goal not in (None, NO_CLIENT)), *watching, *self._planned)

    @property
    def is_idle(self) -> bool:
        """Whether it has neither a motion nor anything to monitor."""
        is_gripping = self._gripper is not None and self._gripper.is_busy
        return self._motion.course is None and not is_gripping and not self._planned

    @property
    def remaining(self) -> float:
        """Remaining time of its motion [s]."""
        return self._motion.remaining

    def states(self) -> JointStates:
        """Return the states of its joints and fingers."""
        return self._engine.joint_states(self._robot)

    def position_of(self, joint: str) -> float:
        """Return the position of a joint or finger [rad, m].

        Raises:
            RequestRefused: The joint is unknown.
        """
        if joint not in self.joints:
            raise unknown(f"joint {joint!r} of {self._robot}", "joints", self.joints)
        return float(self.states().positions[self.joints.index(joint)])

    def velocity_at(
        self, link: str, point: Sequence[float], joints: Sequence[float], rates: Sequence[float]
    ) -> Array:
        """Return the velocity of a point of a link in `map` [m/s], by the joints of arm and gripper.

        Args:
            link: Name of the link.
            point: Point in `map` [m].
            joints: Positions of the arm's joints and the fingers [rad, m].
            rates: Velocities of the arm's joints and the fingers [rad/s, m/s].
        """
        in_map = base_in_map(self._engine, self._robot)
        place = (inverse(in_map) @ (*point, 1.0))[:3]
        turned: Array = in_map[:3, :3] @ self._moved.velocity_at(link, np.array(joints), np.array(rates), place)
        if link not in self._fingers:
            return turned
        rate = rates[len(self._planner.joints) + self._fingers.index(link)]
        return turned + self.gripper.finger_speed(rate) * self._outward(link)

    def _outward(self, finger: str) -> Array:
        """Return the opening direction of a finger in `map`; zero where the fingers meet."""
        here, there = (
            np.array(self._engine.link_pose(self._robot, link)[0])
            for link in (finger, *(other for other in self._fingers if other != finger))
        )
        apart: Array = here - there
        length = float(np.linalg.norm(apart))
        return apart / length if length > 0.0 else apart

    def tool_pose(self) -> Array:
        """Return the pose of the tool in `map`, shape (4, 4)."""
        return self._tool.pose_base_in_map @ self._tool.chain.tool_pose(self._configuration())

    def in_map(self, pose: Array, frame: str) -> Array:
        """Transform a pose from a frame, `map` or the arm's base, to `map`.

        Raises:
            RequestRefused: The frame is unknown.
        """
        if frame == "map":
            return pose
        known = (BASE_FRAME, f"{self._robot}/{BASE_FRAME}")
        if frame not in known:
            raise unknown(f"frame {frame!r} of a pose for {self._robot}", "frames", ("map", *known))
        return self._tool.pose_base_in_map @ pose

    def _configuration(self) -> Array:
        return self.states().positions[: len(self._planner.joints)]

    # ------------------------------------------------------------ goals

    def follow(
        self, goal: str, configurations: Sequence[Sequence[float]], names: Sequence[str], options: MotionOptions
    ) -> None:
        """Move the joints through configurations [rad], [m], in the order of `names` or that of the arm.

        Joints without a name keep the position of their last goal.

        Raises:
            RequestRefused: The arm is busy, or planning fails. This also holds for the other motions.
        """
        if not 1 <= len(configurations) <= MAX_WAYPOINTS:
            raise operation_failed(f"found {len(configurations)} waypoints; expected 1 to {MAX_WAYPOINTS}")
        order = self._order(names)
        points = []
        for positions in configurations:
            check_count(self._robot, names or self._planner.joints, positions)
            point = (self._configuration() if self._posture is None else self._posture).copy()
            point[order] = positions
            points.append(point)
        self._start(goal, options, lambda now: self._planner.through(now, points))

    def take_posture(self, goal: str, posture: str, options: MotionOptions) -> None:
        """Move the joints to a declared posture.

        Raises:
            RequestRefused: The posture is unknown.
        """
        if posture not in self._postures:
            raise unknown(f"posture {posture!r} of {self._robot}", "postures", self._postures)
        positions = self._postures[posture].of(self._planner.joints)
        self.follow(goal, (tuple(positions.values()),), tuple(positions), options)

    def move_to_pose(self, goal: str, target: Array, options: MotionOptions) -> None:
        """Move the tool to a pose in `map`, shape (4, 4), on a path in joint space."""
        self._start(goal, options, lambda now: self._tool.to_pose(now, target))

    def move_straight(self, goal: str, target: Array, options: MotionOptions) -> None:
        """Move the tool to a pose in `map`, shape (4, 4), on a straight line."""
        self._start(goal, options, lambda now: self._tool.straight(now, target))

    def hold(self, goal: str, entity: str, duration: float, tick: int) -> None:
        """Report whether an entity stays held for a duration [s]; an empty name means the held entity.

        Raises:
            RequestRefused: The entity is not held.
        """
        held = self.gripper.check_hold(entity)
        self.gripper.holds.append(HoldGoal(goal, held, tick + math.ceil(duration / TICK - 1e-9)))

    def _start(self, goal: str, options: MotionOptions, plan: Callable[[PlanningScene], Path]) -> None:
        if self._motion.goal not in (None, NO_CLIENT):
            raise incorrect_state(
                f"{self._robot} is busy with goal {self._motion.goal!r}; cancel it or wait for its end"
            )
        start = self._configuration()
        path = plan(PlanningScene(start, self._load(start), options.may_touch))
        if options.plan_only:
            self._planned.append(goal)
            return
        self._posture = path.points[-1]
        speed = options.scaling * self._planner.limits.speed
        self._motion.follow(JointMotion(goal, options.tolerance, path.points, speed, self._acceleration))

    def _order(self, names: Sequence[str]) -> list[int]:
        """Return the indices of `names` in the joints of the arm."""
        joints = self._planner.joints
        unknown_names = [name for name in names if name not in joints]
        if unknown_names or len(set(names)) < len(names):
            raise operation_failed(
                f"invalid joints {', '.join(names)}; expected different ones of {self._robot}: {', '.join(joints)}"
            )
        return [joints.index(name) for name in names or joints]

    def _load(self, configuration: Array) -> AttachedObject | None:
        held = self.held
        if held is None:
            return None
        state = self._engine.body_state(held)
        tool = self._tool.pose_base_in_map @ self._tool.chain.tool_pose(configuration)
        pose = pose_matrix(state.position, rotation_matrix(state.orientation))
        return AttachedObject(held, inverse(tool) @ pose)

    # ------------------------------------------------------------ ticks

    def tick(self, tick: int) -> Iterator[GoalResult]:
        """Update with a tick; yields the results of goals that ended."""
        for goal in self._planned:
            yield GoalResult(goal, Outcome.SUCCEEDED)
        self._planned = []
        self.servos.commanded_speed = 0.0
        if self._gripper is not None:
            self._gripper.commanded_speed = 0.0
        if self.is_idle:
            return
        states = self.states()
        moment, ended = self._motion.tick(states)
        if moment is not None:
            self.servos.set_command(moment)
        if ended is not None:
            if ended.outcome is not Outcome.SUCCEEDED:
                self._posture = None
            yield self._with_contacts(ended)
        if self._gripper is not None:
            yield from self._gripper.tick(states, tick)

    def _with_contacts(self, ended: GoalResult) -> GoalResult:
        """Return a result whose message names the arm's contacts, a possible reason."""
        if ended.outcome is not Outcome.ABORTED:
            return ended
        touched = sorted(self._engine.link_contacts(self._robot))
        against = [f"{link} touches {other!r}" for link, other in touched if other != self.held]
        message = f"{ended.message}; {', '.join(against)}" if against else ended.message
        return GoalResult(ended.id, ended.outcome, f"{self._robot}: {message}")

    def cancel(self, goal: str) -> Iterator[GoalResult]:
        """Cancel a goal; a moving arm comes to rest on its path."""
        if goal not in self.goals:
            return
        if self._motion.goal == goal:
            self._motion.brake()
            self._posture = None
        if self._gripper is not None:
            self._gripper.cancel(goal)
        self._planned = [planned for planned in self._planned if planned != goal]
        yield GoalResult(goal, Outcome.CANCELED)

    def detach_goals(self, goals: Container[str]) -> None:
        """See `Robot.detach_goals`."""
        if self._motion.goal is not None and self._motion.goal in goals:
            self._motion.rename(NO_CLIENT)
        if self._gripper is not None:
            self._gripper.detach_goals(goals)
        self._planned = [planned for planned in self._planned if planned not in goals]

    def stop(self) -> Iterator[GoalResult]:
        """Cancel all goals; a held entity stays held."""
        for goal in self.goals:
            yield from self.cancel(goal)
        if self._motion.course is not None:
            self._motion.brake()
            self._posture = None
        if self._gripper is not None:
            self._gripper.stop()
