"""Force-torque sensors at joints."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from seoro.bridges.wire import Quantity
from seoro.deferred import dataclass
from sim_nodes.geometry import Array, Vector
from sim_nodes.noise import Noise
from sim_nodes.robots.sensor_declarations import ForceTorqueDeclaration
from sim_nodes.sensors.sensor_pipeline import Sensor, Values, period_of


@dataclass(frozen=True)
class Wrench:
    """Load on a joint, in the frame of the link beyond it.

    Attributes:
        force: Force [N], shape (3,); the weight of a tool points down.
        torque: Torque about the origin of the link [N m], shape (3,).
    """

    force: Array
    torque: Array


class ForceTorque(Sensor[Wrench]):
    """A sensor of the load on a joint.

    Args:
        declaration: Declaration of the sensor.
        noise: Source of random numbers.
        load: Returns the true force and torque, as `Engine.joint_load`.
    """

    quantities = (Quantity.FORCE, Quantity.TORQUE)

    def __init__(
        self, declaration: ForceTorqueDeclaration, noise: Noise, load: Callable[[], tuple[Vector, Vector]]
    ) -> None:
        self._declaration = declaration
        self._noise = noise
        self._load = load
        self.period = period_of(declaration.rate)

    def read(self, tick: int) -> Wrench:
        """Return the load with the noise of a tick."""
        force, torque = self._load()
        errors = self._noise.at(tick).standard_normal((2, 3))
        return Wrench(
            np.add(force, self._declaration.force_noise * errors[0]),
            np.add(torque, self._declaration.torque_noise * errors[1]),
        )

    def values(self, data: Wrench) -> Values:
        """Return force and torque."""
        return {Quantity.FORCE: data.force, Quantity.TORQUE: data.torque}

    def with_values(self, data: Wrench, values: Values) -> Wrench:
        """Return another force and torque."""
        return Wrench(values[Quantity.FORCE], values[Quantity.TORQUE])
