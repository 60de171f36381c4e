"""The wheels of a robot: commands, encoders and faults.

A slipping wheel turns on the floor less than about its axle, by a given share. The engine gets the remaining
speed, and the encoder counts the full one. So slip has a defined size; friction alone would make it depend on the
load.
"""

from __future__ import annotations

import numpy as np

from seoro.bridges.wire import Quantity
from sim_nodes.geometry import Array
from sim_nodes.physics import Engine
from sim_nodes.stateful import Stateful
from sim_nodes.ticks import TICK

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
