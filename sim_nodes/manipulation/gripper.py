"""A gripper: it opens and closes at a speed with a limited force, and knows what it holds."""

from __future__ import annotations

from collections.abc import Callable, Container
from dataclasses import dataclass, replace

from seoro.bridges.wire import Outcome, Result
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.goals import NOBODY, Ended
from sim_nodes.manipulation.fingers import Fingers, Pull
from sim_nodes.physics import Engine, JointStates
from sim_nodes.robots.declaration import GripperDeclaration
from sim_nodes.stateful import Stateful
from sim_nodes.ticks import TICK

PRESS = 0.02  # [m] beyond where fingers meet to which closing ones are pulled, to press on thin things, too
STOPPED = 1e-3  # [m] behind where they are pulled to at which fingers that stand still were stopped
STILL = 2e-3  # [m/s]
STALL_TICKS = 10  # for which fingers have to stand still before they count as stopped
LOOSE_TICKS = 5  # for which a finger may not touch before what was held is lost
SETTLE_TIME = 2.0  # [s] in which fingers have to come to rest once they are pulled to their goal


@dataclass(frozen=True)
class GripperGoal:
    """What a gripper is to do: opening [m], and force of each finger at most [N].

    `scaling` is the part of its speed that it may use, `tolerance` how near it has to come to the opening [m].
    """

    id: str
    opening: float
    force: float
    scaling: float
    tolerance: float


@dataclass(frozen=True)
class HoldGoal:
    """That something is held without a break until a tick."""

    id: str
    entity: str
    end: int


class Gripper(Stateful):
    """The gripper of a robot.

    Args:
        robot: Name of the robot.
        declaration: What is declared of its gripper.
        engine: The engine that it is in.
        is_loose: Says whether an entity can be carried.
    """

    STATE = (
        "goal",
        "holds",
        "held",
        "wanted",
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
        self, robot: str, declaration: GripperDeclaration, engine: Engine, is_loose: Callable[[str], bool]
    ) -> None:
        self._robot, self._declaration, self._engine = robot, declaration, engine
        self._is_loose = is_loose
        self.goal: GripperGoal | None = None
        self.holds: list[HoldGoal] = []
        self.held: str | None = None
        self.wanted = (
            0.0  # speed at which the opening was to change in the last tick, with nothing in its way [m/s]
        )
        self.fingers = Fingers(robot, engine, Pull(declaration.stroke, declaration.max_force))
        self._touches = False  # whether a finger touches something, as far as that was looked at
        # Openings [m]: where the last command began, where it leads, and where fingers are pulled to now.
        self._start = self._target = self._ramp = declaration.stroke
        self._force = declaration.max_force
        self._ticks = self._still = self._loose = 0

    def command(self, goal: GripperGoal) -> None:
        """Take up a goal.

        Raises:
            RequestRefused: Busy, or the gripper cannot do that.
        """
        declared = self._declaration
        if self.goal is not None and self.goal.id != NOBODY:
            raise RequestRefused(
                Result.INCORRECT_STATE,
                f"the gripper of {self._robot} works on goal {self.goal.id!r}: cancel it, or wait for its end",
            )
        if not 0.0 <= goal.opening <= declared.stroke:
            raise RequestRefused(
                Result.OPERATION_FAILED,
                f"the gripper of {self._robot} opens from 0 to {declared.stroke} m, not {goal.opening} m",
            )
        if not declared.min_force <= goal.force <= declared.max_force:
            raise RequestRefused(
                Result.OPERATION_FAILED,
                f"the fingers of {self._robot} press with {declared.min_force:g} to {declared.max_force:g} N, "
                f"not {goal.force:g} N",
            )
        self.goal = goal
        self._start = self.opening()
        self._target, self._force = goal.opening, goal.force
        self._ticks = self._still = 0
        if self._opens:
            self._ramp, self.held = self._start, None if self.fingers.has_power else self.held
        else:  # what is pressed on already stays so
            self._ramp = min(self._start, self._ramp)

    @property
    def usual_force(self) -> float:
        """What its fingers press with where nothing else is asked for [N]."""
        return self._declaration.usual_force

    def check_hold(self, entity: str) -> str:
        """The name of what is held, which has to be an entity of that name unless it is empty.

        Raises:
            RequestRefused: Something else is held, or nothing.
        """
        if self.held is None or (entity and entity != self.held):
            holds = "nothing" if self.held is None else repr(self.held)
            wanted = f", not {entity!r}" if entity else ""
            raise RequestRefused(Result.INCORRECT_STATE, f"{self._robot} holds {holds}{wanted}")
        return self.held

    def disown(self, goals: Container[str]) -> None:
        """See `Robot.disown`."""
        if self.goal is not None and self.goal.id in goals:
            self.goal = replace(self.goal, id=NOBODY)
        self.holds = [hold for hold in self.holds if hold.id not in goals]

    def power(self, on: bool) -> None:
        """Cut off the power, without which fingers stay and press on what they hold, or bring it back."""
        if on == self.fingers.has_power:
            return
        if on and self.goal is not None and self._opens:
            self.held = None
        self.fingers.has_power = True
        if self.held is None:
            self._ramp = self.opening()
            self.fingers.stay(self._ramp, self._force)
        self.fingers.has_power = on

    def moving(self) -> float:
        """Speed with which the opening changes [m/s]."""
        return abs(float(self._engine.joint_states(self._robot).velocities[-2:].sum()))

    def stop(self) -> None:
        """Leave the fingers where they are, if they move; what is held is still pressed on."""
        if self.goal is None:
            return
        self.goal = None
        if self.held is None:
            self._target = self._ramp = min(self._declaration.stroke, max(0.0, self.opening()))
            self._pull(self._ramp)

    @property
    def is_busy(self) -> bool:
        """Whether there is anything to do or to watch in a tick."""
        return self.goal is not None or self.held is not None or bool(self.holds)

    def tick(self, states: JointStates, tick: int) -> list[Ended]:
        """Do what is due in a tick; gives the goals that ended."""
        self._look()
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

    def _look(self) -> None:
        """Find out what is held: what both fingers press on."""
        if self.goal is not None and self._opens:
            return
        if self.goal is None and self.held is None:
            return
        touched = self._engine.link_contacts(self._robot)
        left, right = ({other for link, other in touched if link == finger} for finger in self._declaration.links)
        self._touches = bool(left or right)
        both = sorted(name for name in left & right if self._is_loose(name))
        if both:
            self.held, self._loose = (self.held if self.held in both else both[0]), 0
        else:
            self._loose += 1
            if self._loose > LOOSE_TICKS:
                self.held = None

    def _end_of_hold(self, hold: HoldGoal, tick: int) -> Ended | None:
        if self.held != hold.entity:
            return Ended(hold.id, Outcome.ABORTED, f"{self._robot} has lost {hold.entity!r}")
        return Ended(hold.id, Outcome.SUCCEEDED) if tick >= hold.end else None

    @property
    def _end_of_ramp(self) -> float:
        return self._target if self._target > 0.0 else -2.0 * PRESS

    def _move(self, goal: GripperGoal) -> None:
        """Pull the fingers on, at the speed of the goal."""
        end, step = self._end_of_ramp, goal.scaling * self._declaration.max_speed * TICK
        before = self._ramp
        self._ramp = min(before + step, end) if end > before else max(before - step, end)
        if self._opens or not self._touches:
            self.wanted = abs(self._ramp - before) / TICK
        self._pull(self._ramp)

    def _pull(self, opening: float) -> None:
        self.fingers.pull(opening, self._force)

    def _end(self, states: JointStates, goal: GripperGoal) -> Ended | None:
        self._ticks = self._ticks + 1 if self._ramp == self._end_of_ramp else 0
        opening, speed = self._opening(states), float(states.velocities[-2:].sum())
        is_reached = abs(opening - goal.opening) <= goal.tolerance
        self._still = self._still + 1 if abs(speed) < STILL else 0
        if is_reached and self._still:
            return Ended(goal.id, Outcome.SUCCEEDED)
        if self._still >= STALL_TICKS and abs(self._ramp - opening) > STOPPED:
            if self._opens or not self.fingers.has_power:
                return Ended(
                    goal.id, Outcome.ABORTED, f"the fingers of {self._robot} were stopped at {opening:.3f} m"
                )
            return Ended(goal.id, Outcome.SUCCEEDED, f"the fingers were stopped at {opening:.3f} m")
        if self._ticks * TICK > SETTLE_TIME:
            return Ended(goal.id, Outcome.ABORTED, f"the fingers of {self._robot} came to no rest")
        return None

    def opening(self) -> float:
        """How far the gripper is open [m]."""
        return self._opening(self._engine.joint_states(self._robot))

    def _opening(self, states: JointStates) -> float:
        return float(states.positions[-2:].sum())
