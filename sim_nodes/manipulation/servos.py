"""The motors of an arm's joints, which pull these to positions, and the brakes that hold them without power."""

from __future__ import annotations

import numpy as np

from seoro.bridges.wire import Quantity
from sim_nodes.geometry import Array
from sim_nodes.manipulation.trajectory import Moment
from sim_nodes.physics import Engine
from sim_nodes.stateful import Stateful


class Servos(Stateful):
    """The motors of an arm's joints.

    Args:
        robot: Name of the robot.
        count: How many joints it has, besides fingers.
        engine: The engine that it is in.

    Attributes:
        command: What they were commanded last.
        wanted: Speed of the joint that was to move fastest in the last tick [rad/s].
    """

    STATE = ("command", "wanted", "_has_power", "_is_direct")

    quantity = Quantity.ANGLE

    def __init__(self, robot: str, count: int, engine: Engine) -> None:
        self._robot, self._count, self._engine = robot, count, engine
        self.command = Moment(self._positions(), np.zeros(count))
        self.wanted = 0.0
        self._has_power = True
        self._is_direct = True  # whether they are told at once what is commanded

    def _positions(self) -> Array:
        return self._engine.joint_states(self._robot).positions[: self._count]

    def pull(self, moment: Moment) -> None:
        """Command what the joints are to do until the next tick."""
        self.command = moment
        self.wanted = float(np.abs(moment.velocities).max())
        if self._is_direct and self._has_power:
            self._engine.command_joints(self._robot, *moment)

    def numbers(self, command: Moment) -> Array:
        """See `Commanded`."""
        return command.positions

    def with_numbers(self, command: Moment, numbers: Array) -> Moment:
        """See `Commanded`."""
        return Moment(numbers, command.velocities)

    def direct(self, on: bool) -> None:
        """See `Commanded`."""
        self._is_direct = on
        self.tell(self.command)

    def tell(self, command: Moment) -> None:
        """See `Commanded`. Joints go to the positions and stay there, since nothing more may come."""
        if self._has_power:
            self._engine.command_joints(self._robot, command.positions, np.zeros(self._count))

    def power(self, on: bool) -> None:
        """Cut off the power of the joints, whose brakes hold them then, or bring it back."""
        if self._has_power and not on:
            self._engine.command_joints(self._robot, self._positions(), np.zeros(self._count))
        self._has_power = on

    def moving(self) -> float:
        """Speed of the joint that moves fastest [rad/s]."""
        return float(np.abs(self._engine.joint_states(self._robot).velocities[: self._count]).max())
