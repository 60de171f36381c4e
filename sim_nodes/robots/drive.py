"""Drives: wheels with faults, velocity commands, and the battery; see `kinematics.py` for the geometry.

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

from operator import add

import numpy as np

from seoro.bridges.wire import Outcome, Quantity
from seoro.deferred import dataclass
from sim_nodes.geometry import Array
from sim_nodes.outcomes import GoalResult, operation_failed
from sim_nodes.physics import Engine
from sim_nodes.robots.declaration import BatteryDeclaration
from sim_nodes.robots.drive_declaration import DriveDeclaration
from sim_nodes.robots.kinematics import AT_REST, Velocity, per_motor, wheel_joints
from sim_nodes.stateful import Stateful
from sim_nodes.ticks import TICK

PerMotor = tuple[float, ...]
"""Values of the motors of a drive: wheels, then steering joints (`kinematics.py`)."""

GRIP = (0.0, 0.0)


class Wheels(Stateful):
    """The motors of a drive: wheels, and joints that steer.

    Args:
        robot: Name of the robot.
        drive: Declaration of the drive.
        engine: Engine that simulates it.

    Attributes:
        command: Commanded speeds of the wheels [rad/s] and angles of steering joints [rad].
        applied: Values that reach the motors; equal to `command` without faults.
    """

    quantity = Quantity.ANGULAR_RATE

    STATE = (
        "command",
        "applied",
        "_tick",
        "_interval",
        "_before",
        "_on_floor",
        "_slip",
        "_lost",
        "_has_power",
        "_is_passthrough",
    )

    def __init__(self, robot: str, drive: DriveDeclaration, engine: Engine) -> None:
        self._robot = robot
        self._drive = drive
        self._engine = engine
        self._count = len(wheel_joints(drive))
        self.command: PerMotor = per_motor(drive, 0.0, 0.0, 0.0)
        self.applied = self.command
        self._tick = 0  # of the last update; idle robots are updated less often
        self._interval = TICK  # [s] between the last two updates
        self._before: PerMotor = engine.wheel_angles(robot)  # in the update before the last one [rad]
        self._on_floor = self._before  # [rad]
        self._slip = GRIP
        # Angles counted by the encoders of wheels beyond the motion on the floor [rad].
        self._lost: PerMotor = (0.0,) * self._count
        self._has_power = True
        self._is_passthrough = True  # whether commands reach the motors at once

    def set_targets(self, targets: PerMotor) -> None:
        """Command speeds of the wheels [rad/s] and angles of steering joints [rad]."""
        self.command = targets
        if self._is_passthrough:
            self.apply_command(self.command)

    @property
    def turning(self) -> PerMotor:
        """Latest speeds of the wheels relative to the floor [rad/s]."""
        angles, before = self._on_floor, self._before
        return tuple([(angles[wheel] - before[wheel]) / self._interval for wheel in range(self._count)])

    @property
    def are_driven(self) -> bool:
        """Whether the wheels have a command to turn."""
        return any(self.applied[: self._count])

    @property
    def driven(self) -> PerMotor:
        """Speeds that reach the motors of the wheels [rad/s]."""
        return self.applied[: self._count]

    def to_array(self, command: PerMotor) -> Array:
        """See `MotorGroup`."""
        return np.array(command[: self._count])

    def with_array(self, command: PerMotor, numbers: Array) -> PerMotor:
        """See `MotorGroup`."""
        return (*numbers.tolist(), *command[self._count :])

    def set_passthrough(self, on: bool) -> None:
        """See `MotorGroup`."""
        self._is_passthrough = on
        if on:
            self.apply_command(self.command)

    def apply_command(self, command: PerMotor) -> None:
        """See `MotorGroup`."""
        self.applied = command
        if self._slip == GRIP:
            self._engine.command_wheels(self._robot, *command)
            return
        slips = per_motor(self._drive, *self._slip, 0.0)
        targets = [(1.0 - slip) * target for slip, target in zip(slips, command, strict=True)]
        self._engine.command_wheels(self._robot, *targets)

    def slip(self, left: float, right: float) -> None:
        """Set the slip of the wheels of each side, as shares of their motion."""
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
        interval = self._interval = (tick - self._tick) * TICK
        self._tick = tick
        self._before, self._on_floor = self._on_floor, self._engine.wheel_angles(self._robot)
        if self._has_power and self._slip != GRIP:
            slips, lost = per_motor(self._drive, *self._slip, 0.0), self._lost
            self._lost = tuple([lost[at] + slips[at] * self.applied[at] * interval for at in range(self._count)])

    def encoders(self) -> PerMotor:
        """Return the angles counted by the encoders up to the last tick [rad]."""
        return (*map(add, self._on_floor, self._lost), *self._on_floor[self._count :])


COMMAND_TIMEOUT = 0.5  # [s]
ROUNDED = 1e-6  # relative error of a turning radius


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
        drive = self._drive
        linear, angular, lateral = drive.max_speed, drive.max_turn_rate, drive.max_lateral_speed
        if velocity.lateral and not lateral:
            raise operation_failed(f"unsupported motion of {robot} sideways: its drive is {drive.kind.value}")
        if abs(velocity.linear) > linear or abs(velocity.angular) > angular or abs(velocity.lateral) > lateral:
            sideways = f", {lateral:g} m/s sideways" if lateral else ""
            found = f", {velocity.lateral:g} m/s sideways" if lateral else ""
            raise operation_failed(
                f"invalid velocity for {robot}; expected up to {linear:g} m/s{sideways} and {angular:g} rad/s, "
                f"found {velocity.linear:g} m/s{found} and {velocity.angular:g} rad/s"
            )
        if abs(velocity.linear) < abs(velocity.angular) * drive.min_turning_radius * (1.0 - ROUNDED):
            raise operation_failed(
                f"invalid velocity for {robot}: {velocity.linear:g} m/s and {velocity.angular:g} rad/s; "
                f"expected a turning radius of {drive.min_turning_radius:g} m or more, because it steers"
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
        drive, wanted, present = self._drive, command.velocity, self._velocity
        if present == wanted:
            self._velocity = wanted
        else:
            self._velocity = Velocity(
                _towards(present.linear, wanted.linear, drive.max_acceleration * TICK),
                _towards(present.angular, wanted.angular, drive.max_turn_acceleration * TICK),
                _towards(present.lateral, wanted.lateral, drive.max_acceleration * TICK),
            )
        return _possible(drive, self._velocity), None


def _possible(drive: DriveDeclaration, velocity: Velocity) -> Velocity:
    """Return the velocity with a turn rate that the drive can have at its speed."""
    if not drive.min_turning_radius:
        return velocity
    most = abs(velocity.linear) / drive.min_turning_radius
    return velocity._replace(angular=min(max(velocity.angular, -most), most))


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
        drawn = self._power_ticks * TICK / HOUR  # [Wh]
        return max(0.0, declared.charge - drawn / declared.capacity)

    @property
    def drawn(self) -> float:
        """Energy drawn up to the last update [J], also beyond an empty battery."""
        return self._power_ticks * TICK

    @property
    def _power_ticks(self) -> float:
        """Sum of the power over all ticks [W]."""
        return self._standing * self._declaration.idle + self._driving * self._declaration.driving
