"""The wheels of a robot between those who command and read them and the engine, with their faults.

A wheel that slips by a share turns on the floor by so much less than it turns about its axle: the engine is told
to turn it by what is left, and its encoder counts what it was told beyond that. So slip has a size, which
friction alone has not: how much a wheel slips by that hangs on what it has to pull.
"""

from __future__ import annotations

import numpy as np

from seoro.bridges.wire import Quantity
from sim_nodes.geometry import Array
from sim_nodes.physics import Engine
from sim_nodes.stateful import Stateful
from sim_nodes.ticks import TICK

PerWheel = tuple[float, float]
"""Of the left and the right wheel."""

GRIP = (0.0, 0.0)


class Wheels(Stateful):
    """The left and the right wheel of a robot.

    Args:
        robot: Name of the robot.
        engine: The engine that it is in.

    Attributes:
        command: Speeds that were commanded last [rad/s].
        told: Speeds that the motors were told last [rad/s]; the same, if the way to them is sound.
        turning: Speeds at which they have turned on the floor of late [rad/s].
    """

    quantity = Quantity.ANGULAR_RATE

    STATE = ("command", "told", "turning", "_tick", "_on_floor", "_slip", "_lost", "_has_power", "_is_direct")

    def __init__(self, robot: str, engine: Engine) -> None:
        self._robot = robot
        self._engine = engine
        self.command = self.told = (0.0, 0.0)
        self.turning = (0.0, 0.0)
        self._tick = 0  # of the last look: a robot that is idle is looked at now and then only
        self._on_floor = engine.wheel_angles(robot)  # [rad]
        self._slip = GRIP
        self._lost = (0.0, 0.0)  # angles that the encoders counted beyond what was turned on the floor [rad]
        self._has_power = True
        self._is_direct = True  # whether motors are told at once what is commanded

    def turn(self, left: float, right: float) -> None:
        """Command speeds [rad/s]."""
        self.command = (left, right)
        if self._is_direct:
            self.tell(self.command)

    def numbers(self, command: PerWheel) -> Array:
        """See `Commanded`."""
        return np.array(command)

    def with_numbers(self, command: PerWheel, numbers: Array) -> PerWheel:
        """See `Commanded`."""
        left, right = numbers.tolist()
        return left, right

    def direct(self, on: bool) -> None:
        """See `Commanded`."""
        self._is_direct = on
        if on:
            self.tell(self.command)

    def tell(self, command: PerWheel) -> None:
        """See `Commanded`."""
        self.told = left, right = command
        slip_left, slip_right = self._slip
        self._engine.command_wheels(self._robot, (1.0 - slip_left) * left, (1.0 - slip_right) * right)

    def slip(self, left: float, right: float) -> None:
        """Let the wheels slip by shares of what they turn."""
        if self._slip != (left, right):
            self._slip = (left, right)
            self.tell(self.told)

    def power(self, on: bool) -> None:
        """Cut off the power of the motors, or bring it back."""
        if self._has_power != on:
            self._has_power = on
            self._engine.power_wheels(self._robot, on)

    def pass_tick(self, tick: int) -> None:
        """See how the wheels have turned since the last look."""
        (left, right), (was_left, was_right) = self._engine.wheel_angles(self._robot), self._on_floor
        interval = (tick - self._tick) * TICK
        self._tick = tick
        self.turning = ((left - was_left) / interval, (right - was_right) / interval)
        self._on_floor = (left, right)
        if self._has_power and self._slip != GRIP:
            (left, right), (slip_left, slip_right) = self.told, self._slip
            lost_left, lost_right = self._lost
            self._lost = (lost_left + slip_left * left * interval, lost_right + slip_right * right * interval)

    def encoders(self) -> tuple[float, float]:
        """Angles that the encoders had counted in the last tick [rad]."""
        (left, right), (lost_left, lost_right) = self._on_floor, self._lost
        return left + lost_left, right + lost_right
