"""Gripper: opens and closes at a speed with a limited force, and detects the held object."""

from __future__ import annotations

from collections.abc import Callable, Container
from dataclasses import replace

import numpy as np

from seoro.bridges.wire import Outcome
from seoro.deferred import dataclass
from sim_nodes.manipulation.servos import FingerCommand, Fingers
from sim_nodes.outcomes import NO_CLIENT, GoalResult, incorrect_state, operation_failed
from sim_nodes.physics import Engine, JointStates
from sim_nodes.robots.declaration import GripperDeclaration
from sim_nodes.stateful import Stateful
from sim_nodes.ticks import TICK

PRESS = 0.02  # [m] target of closing fingers beyond the point where they meet, to press on thin bodies as well
STOPPED = 1e-3  # [m] lag behind the target at which standing fingers count as stopped
STILL = 2e-3  # [m/s]
STALL_TICKS = 10  # of standstill before fingers count as stopped
LOOSE_TICKS = 5  # without contact of a finger before a held entity counts as lost
SETTLE_TIME = 2.0  # [s] for fingers to come to rest at their goal


@dataclass(frozen=True)
class GripperGoal:
    """Goal of a gripper: opening [m], and maximum force of each finger [N].

    `scaling` is the share of its maximum speed, `tolerance` the maximum error of the opening [m].
    """

    id: str
    opening: float
    force: float
    scaling: float
    tolerance: float


@dataclass(frozen=True)
class HoldGoal:
    """Goal to hold an entity without interruption until a tick."""

    id: str
    entity: str
    end: int


class Gripper(Stateful):
    """The gripper of a robot.

    Args:
        robot: Name of the robot.
        declaration: Declaration of the gripper.
        engine: Engine that simulates it.
        is_movable: Returns whether an entity can be carried.
    """

    STATE = (
        "goal",
        "holds",
        "held",
        "commanded_speed",
        "fingers",
        "_touches",
        "_start",
        "_target",
        "_ramp",
        "_force",
        "_ticks",
        "_still",
        "_loose",
    )

    def __init__(
        self, robot: str, declaration: GripperDeclaration, engine: Engine, is_movable: Callable[[str], bool]
    ) -> None:
        self._robot, self._declaration, self._engine = robot, declaration, engine
        self._is_movable = is_movable
        self.goal: GripperGoal | None = None
        self.holds: list[HoldGoal] = []
        self.held: str | None = None
        self.commanded_speed = 0.0  # commanded speed of the opening in the last tick, without obstacles [m/s]
        self.fingers = Fingers(
            robot, declaration, engine, FingerCommand(declaration.stroke, declaration.max_force)
        )
        self._touches = False  # whether a finger touches something, at the last check
        # Openings [m]: start and end of the last command, and present target of the fingers.
        self._start = self._target = self._ramp = declaration.stroke
        self._force = declaration.max_force
        self._ticks = self._still = self._loose = 0

    def command(self, goal: GripperGoal) -> None:
        """Accept a goal.

        Raises:
            RequestRefused: The gripper is busy, or the goal is out of range.
        """
        declared = self._declaration
        if self.goal is not None and self.goal.id != NO_CLIENT:
            raise incorrect_state(
                f"the gripper of {self._robot} is busy with goal {self.goal.id!r}; cancel it or wait for its end"
            )
        if not 0.0 <= goal.opening <= declared.stroke:
            raise operation_failed(
                f"invalid opening {goal.opening} m; expected 0 to {declared.stroke} m for {self._robot}"
            )
        if not declared.min_force <= goal.force <= declared.max_force:
            raise operation_failed(
                f"invalid force {goal.force:g} N; expected {declared.min_force:g} to {declared.max_force:g} N "
                f"for the fingers of {self._robot}"
            )
        self.goal = goal
        self._start = self.opening()
        self._target, self._force = goal.opening, goal.force
        self._ticks = self._still = 0
        if self._opens:
            self._ramp, self.held = self._start, None if self.fingers.has_power else self.held
        else:  # a pressed object stays pressed
            self._ramp = min(self._start, self._ramp)

    @property
    def usual_force(self) -> float:
        """Default force of each finger [N]."""
        return self._declaration.usual_force

    def check_hold(self, entity: str) -> str:
        """Return the name of the held entity, which must be `entity` unless that is empty.

        Raises:
            RequestRefused: Another entity is held, or none.
        """
        if self.held is None or (entity and entity != self.held):
            holds = "nothing" if self.held is None else repr(self.held)
            expected = f", not {entity!r}" if entity else ""
            raise incorrect_state(f"{self._robot} holds {holds}{expected}")
        return self.held

    def detach_goals(self, goals: Container[str]) -> None:
        """See `Robot.detach_goals`."""
        if self.goal is not None and self.goal.id in goals:
            self.goal = replace(self.goal, id=NO_CLIENT)
        self.holds = [hold for hold in self.holds if hold.id not in goals]

    def cancel(self, goal: str) -> None:
        """Cancel a goal by id, if it is one of the gripper."""
        if self.goal is not None and self.goal.id == goal:
            self.stop()
        self.holds = [hold for hold in self.holds if hold.id != goal]

    def set_power(self, on: bool) -> None:
        """Switch the power; without power, the fingers hold their positions and press on a held object."""
        if on == self.fingers.has_power:
            return
        if on and self.goal is not None and self._opens:
            self.held = None
        self.fingers.has_power = True
        if self.held is None:
            self._ramp = self.opening()
            self.fingers.hold_position(self._ramp, self._force)
        self.fingers.has_power = on

    def fastest(self) -> float:
        """Return the speed of the opening [m/s]."""
        return abs(self._declaration.opening_speed(self._engine.joint_states(self._robot).velocities[-2:]))

    def finger_speed(self, rate: float) -> float:
        """Return the speed at which a finger opens [m/s] at a velocity of its joint."""
        return self._declaration.opening_speed(np.array([rate]))

    def stop(self) -> None:
        """Stop the fingers where they are; a held entity stays pressed."""
        if self.goal is None:
            return
        self.goal = None
        if self.held is None:
            self._target = self._ramp = min(self._declaration.stroke, max(0.0, self.opening()))
            self.fingers.set_command(self._ramp, self._force)

    @property
    def is_busy(self) -> bool:
        """Whether it has something to do or to monitor in every tick."""
        return self.goal is not None or self.held is not None or bool(self.holds)

    def tick(self, states: JointStates, tick: int) -> list[GoalResult]:
        """Update with a tick; returns the results of goals that ended."""
        self._detect_held()
        ended = [end for hold in self.holds if (end := self._end_of_hold(hold, tick)) is not None]
        over = {end.id for end in ended}
        self.holds = [hold for hold in self.holds if hold.id not in over]
        if self.goal is not None:
            self._move(self.goal)
            end = self._end(states, self.goal)
            if end is not None:
                self.goal = None
                ended.append(end)
        return ended

    @property
    def _opens(self) -> bool:
        return self._target > self._start

    def _detect_held(self) -> None:
        """Detect the held entity: a movable one that both fingers touch."""
        if self.goal is not None and self._opens:
            return
        if self.goal is None and self.held is None:
            return
        touched = self._engine.link_contacts(self._robot)
        left, right = ({other for link, other in touched if link == finger} for finger in self._declaration.links)
        self._touches = bool(left or right)
        both = sorted(name for name in left & right if self._is_movable(name))
        if both:
            self.held, self._loose = (self.held if self.held in both else both[0]), 0
        else:
            self._loose += 1
            if self._loose > LOOSE_TICKS:
                self.held = None

    def _end_of_hold(self, hold: HoldGoal, tick: int) -> GoalResult | None:
        if self.held != hold.entity:
            return GoalResult(hold.id, Outcome.ABORTED, f"{self._robot} has lost {hold.entity!r}")
        return GoalResult(hold.id, Outcome.SUCCEEDED) if tick >= hold.end else None

    @property
    def _end_of_ramp(self) -> float:
        return self._target if self._target > 0.0 else -2.0 * PRESS

    def _move(self, goal: GripperGoal) -> None:
        """Move the target of the fingers at the speed of the goal."""
        end, step = self._end_of_ramp, goal.scaling * self._declaration.max_speed * TICK
        before = self._ramp
        self._ramp = min(before + step, end) if end > before else max(before - step, end)
        if self._opens or not self._touches:
            self.commanded_speed = abs(self._ramp - before) / TICK
        self.fingers.set_command(self._ramp, self._force)

    def _end(self, states: JointStates, goal: GripperGoal) -> GoalResult | None:
        self._ticks = self._ticks + 1 if self._ramp == self._end_of_ramp else 0
        opening, speed = self._opening(states), self._declaration.opening_speed(states.velocities[-2:])
        is_reached = abs(opening - goal.opening) <= goal.tolerance
        self._still = self._still + 1 if abs(speed) < STILL else 0
        if is_reached and self._still:
            return GoalResult(goal.id, Outcome.SUCCEEDED)
        if self._still >= STALL_TICKS and abs(self._ramp - opening) > STOPPED:
            if self._opens or not self.fingers.has_power:
                return GoalResult(
                    goal.id, Outcome.ABORTED, f"the fingers of {self._robot} were stopped at {opening:.3f} m"
                )
            return GoalResult(goal.id, Outcome.SUCCEEDED, f"the fingers were stopped at {opening:.3f} m")
        if self._ticks * TICK > SETTLE_TIME:
            return GoalResult(goal.id, Outcome.ABORTED, f"the fingers of {self._robot} did not come to rest")
        return None

    def opening(self) -> float:
        """Return the opening of the gripper [m]."""
        return self._opening(self._engine.joint_states(self._robot))

    def _opening(self, states: JointStates) -> float:
        return self._declaration.opening_of(states.positions[-2:])
