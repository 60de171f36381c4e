"""The contract of sensors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

from seoro.bridges.wire import Quantity
from sim_nodes.geometry import Array

T = TypeVar("T")

Values = Mapping[Quantity, Array]


class Sensor(Protocol[T]):
    """A sensor with data of type T; the numbers in the data can be read and replaced by quantity."""

    @property
    def period(self) -> int:
        """Ticks between two samples."""

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """Quantities of `values`, in order."""

    @property
    def bearings(self) -> Array:
        """Directions of its beams, counterclockwise from straight ahead [rad], shape (n,); empty without beams."""

    @property
    def limits(self) -> tuple[float, float]:
        """Minimum and maximum of its numbers; values beyond are infinite in its data."""

    def read(self, tick: int) -> T:
        """Return the present data, with the errors of a sound sensor in a tick."""

    def values(self, data: T) -> Values:
        """Return the numbers in data; one for each beam, infinite without a return."""

    def with_values(self, data: T, values: Values) -> T:
        """Return the data with other numbers."""


@dataclass(frozen=True)
class Sample(Generic[T]):
    """Data of a sensor and their tick."""

    tick: int
    data: T
