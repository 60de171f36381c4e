"""Differential drives: kinematics, wheels with faults, velocity commands, and the battery.

A slipping wheel turns on the floor less than about its axle, by a given share. The engine gets the remaining
speed, and the encoder counts the full one. So slip has a defined size; friction alone would make it depend on the
load.

A goal to drive holds its velocity for a number of ticks. A command holds until the next one, and for
`COMMAND_TIMEOUT` at most, as on the Create 3, so that a robot stops when its commander dies. Wheels accelerate
within the limits of the robot; at the end they stop at once.

A battery has one constant power draw at rest and another while driving. Nothing else draws power, and nothing
charges it. At a charge of 0, the robot keeps working.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from seoro.bridges.wire import Outcome, Quantity
from sim_nodes.geometry import Array
from sim_nodes.outcomes import GoalResult, operation_failed
from sim_nodes.physics import Engine
from sim_nodes.robots.declaration import BatteryDeclaration, DriveDeclaration
from sim_nodes.stateful import Stateful
from sim_nodes.ticks import TICK


class Velocity(NamedTuple):
    """Velocity of a base: forwards [m/s] and turning left [rad/s]."""

    linear: float
    angular: float


AT_REST = Velocity(0.0, 0.0)


def wheel_speeds(drive: DriveDeclaration, velocity: Velocity) -> tuple[float, float]:
    """Return the ground speed at the left and right wheel [m/s]."""
    half = velocity.angular * drive.wheel_separation / 2.0
    return velocity.linear - half, velocity.linear + half


def wheel_angular_speeds(drive: DriveDeclaration, velocity: Velocity) -> tuple[float, float]:
    """Return the angular speed of the left and right wheel [rad/s] for a velocity of the base."""
    left, right = wheel_speeds(drive, velocity)
    return left / drive.wheel_radius, right / drive.wheel_radius


def base_motion(drive: DriveDeclaration, left: float, right: float) -> tuple[float, float]:
    """Return the distance [m] and change of heading [rad] of a base whose wheels turned by these angles [rad]."""
    left_way, right_way = left * drive.wheel_radius, right * drive.wheel_radius
    return (left_way + right_way) / 2.0, (right_way - left_way) / drive.wheel_separation


PerWheel = tuple[float, float]
"""Values of the left and the right wheel."""

GRIP = (0.0, 0.0)


class Wheels(Stateful):
    """The left and right wheel of a robot.

    Args:
        robot: Name of the robot.
        engine: Engine that simulates it.

    Attributes:
        command: Commanded speeds [rad/s].
        applied: Speeds that reach the motors [rad/s]; equal to `command` without faults.
        turning: Latest speeds relative to the floor [rad/s].
    """

    quantity = Quantity.ANGULAR_RATE

    STATE = (
        "command",
        "applied",
        "turning",
        "_tick",
        "_on_floor",
        "_slip",
        "_lost",
        "_has_power",
        "_is_passthrough",
    )

    def __init__(self, robot: str, engine: Engine) -> None:
        self._robot = robot
        self._engine = engine
        self.command = self.applied = (0.0, 0.0)
        self.turning = (0.0, 0.0)
        self._tick = 0  # of the last update; idle robots are updated less often
        self._on_floor = engine.wheel_angles(robot)  # [rad]
        self._slip = GRIP
        self._lost = (0.0, 0.0)  # angles counted by the encoders beyond the motion on the floor [rad]
        self._has_power = True
        self._is_passthrough = True  # whether commands reach the motors at once

    def set_speeds(self, left: float, right: float) -> None:
        """Command speeds [rad/s]."""
        self.command = (left, right)
        if self._is_passthrough:
            self.apply_command(self.command)

    def to_array(self, command: PerWheel) -> Array:
        """See `MotorGroup`."""
        return np.array(command)

    def with_array(self, command: PerWheel, numbers: Array) -> PerWheel:
        """See `MotorGroup`."""
        left, right = numbers.tolist()
        return left, right

    def set_passthrough(self, on: bool) -> None:
        """See `MotorGroup`."""
        self._is_passthrough = on
        if on:
            self.apply_command(self.command)

    def apply_command(self, command: PerWheel) -> None:
        """See `MotorGroup`."""
        self.applied = left, right = command
        slip_left, slip_right = self._slip
        self._engine.command_wheels(self._robot, (1.0 - slip_left) * left, (1.0 - slip_right) * right)

    def slip(self, left: float, right: float) -> None:
        """Set the slip of the wheels, as shares of their motion."""
        if self._slip != (left, right):
            self._slip = (left, right)
            self.apply_command(self.applied)

    def set_power(self, on: bool) -> None:
        """Switch the power of the motors."""
        if self._has_power != on:
            self._has_power = on
            self._engine.power_wheels(self._robot, on)

    def update(self, tick: int) -> None:
        """Update with how the wheels have turned since the last update."""
        (left, right), (was_left, was_right) = self._engine.wheel_angles(self._robot), self._on_floor
        interval = (tick - self._tick) * TICK
        self._tick = tick
        self.turning = ((left - was_left) / interval, (right - was_right) / interval)
        self._on_floor = (left, right)
        if self._has_power and self._slip != GRIP:
            (left, right), (slip_left, slip_right) = self.applied, self._slip
            lost_left, lost_right = self._lost
            self._lost = (lost_left + slip_left * left * interval, lost_right + slip_right * right * interval)

    def encoders(self) -> tuple[float, float]:
        """Return the angles counted by the encoders up to the last tick [rad]."""
        (left, right), (lost_left, lost_right) = self._on_floor, self._lost
        return left + lost_left, right + lost_right


COMMAND_TIMEOUT = 0.5  # [s]


@dataclass(frozen=True)
class VelocityCommand:
    """A velocity to drive with until a tick; `goal` is the id of the goal, None for a command."""

    velocity: Velocity
    last: int  # tick
    goal: str | None


class Steering(Stateful):
    """The velocity command of a base, if any.

    Args:
        drive: Declaration with the limits.

    Attributes:
        command: The command, which starts from the present velocity.
    """

    STATE = ("_velocity", "command")

    def __init__(self, drive: DriveDeclaration) -> None:
        self._drive = drive
        self._velocity = AT_REST
        self.command: VelocityCommand | None = None

    @property
    def goal(self) -> str | None:
        """Id of the active goal."""
        return self.command.goal if self.command is not None else None

    def check(self, robot: str, velocity: Velocity) -> None:
        """Refuse velocities beyond the limits of the robot."""
        linear, angular = self._drive.max_speed, self._drive.max_turn_rate
        if abs(velocity.linear) > linear or abs(velocity.angular) > angular:
            raise operation_failed(
                f"invalid velocity for {robot}; expected up to {linear:g} m/s and {angular:g} rad/s, "
                f"found {velocity.linear:g} m/s and {velocity.angular:g} rad/s"
            )

    def clear(self) -> None:
        """Drop the command; the caller must stop the wheels."""
        self.command, self._velocity = None, AT_REST

    def control(self, tick: int) -> tuple[Velocity, GoalResult | None]:
        """Return the velocity from this tick on, and the result of the goal if it ends; requires a command."""
        command = self.command
        assert command is not None
        if tick >= command.last:
            self.clear()
            return AT_REST, GoalResult(command.goal, Outcome.SUCCEEDED) if command.goal is not None else None
        drive = self._drive
        self._velocity = Velocity(
            _towards(self._velocity.linear, command.velocity.linear, drive.max_acceleration * TICK),
            _towards(self._velocity.angular, command.velocity.angular, drive.max_turn_acceleration * TICK),
        )
        return self._velocity, None


def _towards(present: float, wanted: float, by: float) -> float:
    """Return the value nearest to `wanted` that differs from `present` by at most `by`."""
    return min(max(wanted, present - by), present + by)


HOUR = 3600.0  # [s]


class Battery(Stateful):
    """A battery.

    Args:
        declaration: Declaration of the battery.
    """

    STATE = ("_tick", "_standing", "_driving")

    def __init__(self, declaration: BatteryDeclaration) -> None:
        self._declaration = declaration
        self._tick = 0  # of the last update
        # Ticks are counted, so that the charge does not depend on the number of updates.
        self._standing = 0
        self._driving = 0

    def update(self, tick: int, *, drives: bool) -> None:
        """Update with whether the base has driven since the last update."""
        passed, self._tick = tick - self._tick, tick
        if drives:
            self._driving += passed
        else:
            self._standing += passed

    @property
    def charge(self) -> float:
        """Charge from 0 to 1 at the last update."""
        declared = self._declaration
        drawn = (self._standing * declared.idle + self._driving * declared.driving) * TICK / HOUR  # [Wh]
        return max(0.0, declared.charge - drawn / declared.capacity)
