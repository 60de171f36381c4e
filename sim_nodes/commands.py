"""Commands of motors: their way to these is as that of samples from a sensor, and so are the faults on it."""

from __future__ import annotations

import math
from typing import Generic, Protocol, TypeVar

import numpy as np

from seoro.bridges.wire import Quantity
from sim_nodes.geometry import Array
from sim_nodes.sensors.sensor import Values
from sim_nodes.stateful import Stateful

T = TypeVar("T")


class Commanded(Protocol[T]):
    """Motors that are commanded, by what is of one type."""

    @property
    def quantity(self) -> Quantity:
        """What the numbers of a command are."""

    @property
    def command(self) -> T:
        """What was commanded last."""

    def numbers(self, command: T) -> Array:
        """The numbers of a command, shape (n,)."""

    def with_numbers(self, command: T, numbers: Array) -> T:
        """The command with other numbers."""

    def direct(self, on: bool) -> None:
        """Let the motors be told at once what is commanded, or only by those who call `tell`."""

    def tell(self, command: T) -> None:
        """Tell the motors a command."""


class Orders(Stateful, Generic[T]):
    """What motors are commanded, in every tick; a `Sensor`.

    Args:
        motors: The motors.
    """

    period = 1
    limits = (-math.inf, math.inf)
    bearings: Array = np.zeros(0)

    def __init__(self, motors: Commanded[T]) -> None:
        self._motors = motors

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """See `Sensor`."""
        return (self._motors.quantity,)

    def read(self, tick: int) -> T:
        """The last command."""
        return self._motors.command

    def values(self, data: T) -> Values:
        """Its numbers."""
        return {self._motors.quantity: self._motors.numbers(data)}

    def with_values(self, data: T, values: Values) -> T:
        """The command with other numbers."""
        return self._motors.with_numbers(data, values[self._motors.quantity])
