"""Receivers of satellite navigation."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from seoro.bridges.wire import Quantity
from seoro.deferred import dataclass
from sim_nodes.geodesy import GeoPoint, from_local
from sim_nodes.geometry import Array, Vector, vector
from sim_nodes.noise import Noise
from sim_nodes.robots.sensor_declarations import GpsDeclaration
from sim_nodes.sensors.sensor_pipeline import Sensor, Values, period_of
from sim_nodes.ticks import TICK


@dataclass(frozen=True)
class Fix:
    """A measured position: east, north and up of the origin of the world [m], shape (3,), and in WGS 84."""

    position: Array
    point: GeoPoint


class Gps(Sensor[Fix]):
    """A receiver; x of the map is east, y north.

    Args:
        declaration: Declaration of the receiver.
        noise: Source of random numbers.
        origin: Origin of the map.
        antenna: Returns the position of the antenna in the map [m].
    """

    STATE = ("_drift", "_last")

    quantities = (Quantity.LENGTH,)

    def __init__(
        self, declaration: GpsDeclaration, noise: Noise, origin: GeoPoint, antenna: Callable[[], Vector]
    ) -> None:
        self._declaration = declaration
        self._noise = noise
        self._origin = origin
        self._antenna = antenna
        self._drift = np.zeros(3)  # [m]
        self._last: int | None = None  # tick of the last sample
        self.period = period_of(declaration.rate)

    def read(self, tick: int) -> Fix:
        """Return a position with the errors of a tick."""
        declaration = self._declaration
        errors, steps = self._noise.at(tick).standard_normal((2, 3))
        # Exact discretisation of a Gauss-Markov process; the first sample has its stationary distribution.
        kept = 0.0 if self._last is None else math.exp(-(tick - self._last) * TICK / declaration.drift_time)
        self._drift = kept * self._drift + declaration.drift * math.sqrt(1.0 - kept**2) * steps
        self._last = tick
        deviations = (declaration.noise, declaration.noise, declaration.height_noise)
        return self._fix(self._antenna() + self._drift + deviations * errors)

    def values(self, data: Fix) -> Values:
        """Return east, north and up."""
        return {Quantity.LENGTH: data.position}

    def with_values(self, data: Fix, values: Values) -> Fix:
        """Return another position."""
        return self._fix(values[Quantity.LENGTH])

    def _fix(self, position: Array) -> Fix:
        return Fix(position, from_local(self._origin, vector(position)))
