"""An inertial measurement unit at the origin of a robot's base: accelerometer and gyroscope."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from seoro.bridges.wire import Quantity
from sim_nodes.geometry import Array, Vector, rotation_matrix
from sim_nodes.noise import Noise
from sim_nodes.physics import BodyState
from sim_nodes.robots.declaration import ImuDeclaration
from sim_nodes.sensors.sensor import Values
from sim_nodes.stateful import Stateful
from sim_nodes.ticks import TICK

FREE_FALL = np.array([0.0, 0.0, -9.81])  # [m/s^2]


@dataclass(frozen=True)
class Inertial:
    """Data of an IMU, in the frame of the base.

    Attributes:
        acceleration: Proper acceleration: upwards at rest, by gravity [m/s^2], shape (3,).
        angular_rate: Angular velocity [rad/s], shape (3,).
    """

    acceleration: Array
    angular_rate: Array


class Imu(Stateful):
    """A `Sensor`: the IMU of a robot. The acceleration is the mean since the last sample.

    Args:
        declaration: Declaration of the IMU.
        noise: Source of random numbers.
        bias: Source of the constant biases.
        state: Reads the state of the base.
    """

    STATE = ("_last",)

    quantities = (Quantity.ACCELERATION, Quantity.ANGULAR_RATE)
    limits = (-math.inf, math.inf)
    bearings: Array = np.zeros(0)

    def __init__(
        self, declaration: ImuDeclaration, noise: Noise, bias: Noise, state: Callable[[], BodyState]
    ) -> None:
        self._declaration = declaration
        self._noise = noise
        self._state = state
        draws = bias.at(0).standard_normal((2, 3))
        self._biases = (declaration.accelerometer_bias * draws[0], declaration.gyroscope_bias * draws[1])
        self._last: tuple[int, Vector] | None = None  # tick and velocity [m/s] of the last sample
        self.period = max(1, round(1.0 / declaration.rate / TICK))

    def read(self, tick: int) -> Inertial:
        """Return a sample with the noise of a tick."""
        declaration, state = self._declaration, self._state()
        to_base = rotation_matrix(state.orientation).T
        acceleration = to_base @ (self._change(tick, state.linear) - FREE_FALL)
        errors = self._noise.at(tick).standard_normal((2, 3))
        return Inertial(
            acceleration + self._biases[0] + declaration.accelerometer_noise * errors[0],
            to_base @ state.angular + self._biases[1] + declaration.gyroscope_noise * errors[1],
        )

    def _change(self, tick: int, velocity: Vector) -> Array:
        """Return the mean acceleration since the last sample; zero if that is long ago [m/s^2]."""
        last, self._last = self._last, (tick, velocity)
        if last is None or tick - last[0] > self.period:
            return np.zeros(3)
        change: Array = np.subtract(velocity, last[1]) / ((tick - last[0]) * TICK)
        return change

    def values(self, data: Inertial) -> Values:
        """Return both vectors."""
        return {Quantity.ACCELERATION: data.acceleration, Quantity.ANGULAR_RATE: data.angular_rate}

    def with_values(self, data: Inertial, values: Values) -> Inertial:
        """Return data with other vectors."""
        return Inertial(values[Quantity.ACCELERATION], values[Quantity.ANGULAR_RATE])
