"""The motors of a gripper's fingers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from seoro.bridges.wire import Quantity
from sim_nodes.geometry import Array
from sim_nodes.physics import Engine
from sim_nodes.stateful import Stateful


class Pull(NamedTuple):
    """To which opening fingers are pulled [m], and with which force each at most [N]."""

    opening: float
    force: float


class Fingers(Stateful):
    """The motors of a gripper's fingers.

    Args:
        robot: Name of the robot.
        engine: The engine that it is in.
        first: What they are told in the beginning.

    Attributes:
        command: What they were commanded last.
        has_power: Whether they have power; without it they stay as they are.
    """

    STATE = ("command", "has_power", "_is_direct")

    quantity = Quantity.LENGTH

    def __init__(self, robot: str, engine: Engine, first: Pull) -> None:
        self._robot, self._engine = robot, engine
        self.command = first
        self.has_power = True
        self._is_direct = True  # whether they are told at once what is commanded

    def pull(self, opening: float, force: float) -> None:
        """Command them."""
        self.command = Pull(opening, force)
        if self._is_direct:
            self.tell(self.command)

    def stay(self, opening: float, force: float) -> None:
        """Stop them at once where they are, whatever lies on the way of commands."""
        self.command = Pull(opening, force)
        self.tell(self.command)

    def numbers(self, command: Pull) -> Array:
        """See `Commanded`."""
        return np.array([command.opening])

    def with_numbers(self, command: Pull, numbers: Array) -> Pull:
        """See `Commanded`."""
        return Pull(float(numbers[0]), command.force)

    def direct(self, on: bool) -> None:
        """See `Commanded`."""
        self._is_direct = on
        self.tell(self.command)

    def tell(self, command: Pull) -> None:
        """See `Commanded`."""
        if self.has_power:
            self._engine.command_fingers(self._robot, command.opening / 2.0, command.force)
