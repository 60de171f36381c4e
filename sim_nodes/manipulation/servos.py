"""Motors of an arm's joints and of a gripper's fingers; without power, brakes hold the joints."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from seoro.bridges.wire import Quantity
from sim_nodes.geometry import Array
from sim_nodes.manipulation.motion import TrajectoryPoint
from sim_nodes.physics import Engine
from sim_nodes.robots.declaration import GripperDeclaration
from sim_nodes.stateful import Stateful


class Servos(Stateful):
    """The motors of an arm's joints.

    Args:
        robot: Name of the robot.
        count: Number of joints, without fingers.
        engine: Engine that simulates it.

    Attributes:
        command: The last command.
        commanded_speed: Commanded speed of the fastest joint in the last tick [rad/s].
    """

    STATE = ("command", "commanded_speed", "_has_power", "_is_passthrough")

    quantity = Quantity.ANGLE

    def __init__(self, robot: str, count: int, engine: Engine) -> None:
        self._robot, self._count, self._engine = robot, count, engine
        self.command = TrajectoryPoint(self._positions(), np.zeros(count))
        self.commanded_speed = 0.0
        self._has_power = True
        self._is_passthrough = True  # whether commands reach the motors at once

    def _positions(self) -> Array:
        return self._engine.joint_states(self._robot).positions[: self._count]

    def set_command(self, moment: TrajectoryPoint) -> None:
        """Command the joints until the next tick."""
        self.command = moment
        self.commanded_speed = float(np.abs(moment.velocities).max())
        if self._is_passthrough and self._has_power:
            self._engine.command_joints(self._robot, *moment)

    def to_array(self, command: TrajectoryPoint) -> Array:
        """See `MotorGroup`."""
        return command.positions

    def with_array(self, command: TrajectoryPoint, numbers: Array) -> TrajectoryPoint:
        """See `MotorGroup`."""
        return TrajectoryPoint(numbers, command.velocities)

    def set_passthrough(self, on: bool) -> None:
        """See `MotorGroup`."""
        self._is_passthrough = on
        self.apply_command(self.command)

    def apply_command(self, command: TrajectoryPoint) -> None:
        """See `MotorGroup`. Joints go to the positions and stay there, because further commands may be lost."""
        if self._has_power:
            self._engine.command_joints(self._robot, command.positions, np.zeros(self._count))

    def set_power(self, on: bool) -> None:
        """Switch the power of the joints; without it, their brakes hold them."""
        if self._has_power and not on:
            self._engine.command_joints(self._robot, self._positions(), np.zeros(self._count))
        self._has_power = on

    def fastest(self) -> float:
        """Return the speed of the fastest joint [rad/s]."""
        return float(np.abs(self._engine.joint_states(self._robot).velocities[: self._count]).max())


class FingerCommand(NamedTuple):
    """Target opening of the fingers [m], and maximum force of each [N]."""

    opening: float
    force: float


class Fingers(Stateful):
    """The motors of a gripper's fingers.

    Args:
        robot: Name of the robot.
        declaration: Declaration of the gripper.
        engine: Engine that simulates it.
        first: Initial command.

    Attributes:
        command: The last command.
        has_power: Whether they have power; without it they hold their positions.
    """

    STATE = ("command", "has_power", "_is_passthrough")

    quantity = Quantity.LENGTH

    def __init__(self, robot: str, declaration: GripperDeclaration, engine: Engine, first: FingerCommand) -> None:
        self._robot, self._declaration, self._engine = robot, declaration, engine
        self.command = first
        self.has_power = True
        self._is_passthrough = True  # whether commands reach the motors at once

    def set_command(self, opening: float, force: float) -> None:
        """Command the fingers."""
        self.command = FingerCommand(opening, force)
        if self._is_passthrough:
            self.apply_command(self.command)

    def hold_position(self, opening: float, force: float) -> None:
        """Stop the fingers at once, bypassing the command pipeline."""
        self.command = FingerCommand(opening, force)
        self.apply_command(self.command)

    def to_array(self, command: FingerCommand) -> Array:
        """See `MotorGroup`."""
        return np.array([command.opening])

    def with_array(self, command: FingerCommand, numbers: Array) -> FingerCommand:
        """See `MotorGroup`."""
        return FingerCommand(float(numbers[0]), command.force)

    def set_passthrough(self, on: bool) -> None:
        """See `MotorGroup`."""
        self._is_passthrough = on
        self.apply_command(self.command)

    def apply_command(self, command: FingerCommand) -> None:
        """See `MotorGroup`."""
        if self.has_power:
            position, effort = (
                self._declaration.position_of(command.opening),
                self._declaration.effort_of(command.force),
            )
            self._engine.command_fingers(self._robot, position, effort)
