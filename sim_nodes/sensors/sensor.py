"""What all sensors have in common."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

from seoro.bridges.wire import Quantity
from sim_nodes.geometry import Array

T = TypeVar("T")

Values = Mapping[Quantity, Array]


class Sensor(Protocol[T]):
    """A sensor. Its data are of one type; the numbers in them can be taken out and put back by quantity."""

    @property
    def period(self) -> int:
        """Ticks between two samples."""
        ...

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """The quantities of `values`, in order."""
        ...

    @property
    def bearings(self) -> Array:
        """Directions of its beams, from straight ahead to the left [rad], shape (n,); empty if it has no beams."""
        ...

    @property
    def limits(self) -> tuple[float, float]:
        """Lowest and highest number that it gives; what is beyond is infinite in its data."""
        ...

    def read(self, tick: int) -> T:
        """The data of now, with what errors of a tick a sound sensor has."""
        ...

    def values(self, data: T) -> Values:
        """The numbers in data; of beams there is one for each, infinite if it has seen nothing."""
        ...

    def with_values(self, data: T, values: Values) -> T:
        """The data with other numbers."""
        ...


@dataclass(frozen=True)
class Sample(Generic[T]):
    """What a sensor says, and the tick that it says it of."""

    tick: int
    data: T
