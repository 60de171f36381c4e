"""What wheels are commanded, as a sensor of commands: their way to the motors is as that of samples."""

from __future__ import annotations

import math

import numpy as np

from seoro.bridges.wire import Quantity
from sim_nodes.geometry import Array
from sim_nodes.robots.wheels import PerWheel, Wheels
from sim_nodes.sensors.sensor import Values
from sim_nodes.stateful import Stateful


class Orders(Stateful):
    """The speeds that the wheels of a robot are commanded, in every tick [rad/s]; a `Sensor`.

    Args:
        wheels: The wheels.
    """

    period = 1
    quantities = (Quantity.ANGULAR_RATE,)
    limits = (-math.inf, math.inf)
    bearings: Array = np.zeros(0)

    def __init__(self, wheels: Wheels) -> None:
        self._wheels = wheels

    def read(self, tick: int) -> PerWheel:
        """The last command."""
        return self._wheels.command

    def values(self, data: PerWheel) -> Values:
        """The speeds."""
        return {Quantity.ANGULAR_RATE: np.array(data)}

    def with_values(self, data: PerWheel, values: Values) -> PerWheel:
        """Other speeds."""
        left, right = values[Quantity.ANGULAR_RATE].tolist()
        return left, right
