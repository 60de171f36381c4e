"""Common parts of checks of faults.

A check compares what clients of a device receive with what a sound device would have given them. It runs until the
effect is confirmed. It never concludes that a fault has no effect, because that may appear later.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from seoro.bridges.wire import Delay, SensorFault
from sim_nodes.sensors.sensor import Sample
from sim_nodes.stateful import Stateful

T = TypeVar("T")
S = TypeVar("S")

MOST_TRUTHS = 1000  # true samples kept for samples that have not arrived


@dataclass(frozen=True)
class Observation(Generic[T]):
    """Sensor data of a tick.

    Attributes:
        tick: The tick.
        truth: Sample that a sound sensor would have sent.
        arrived: Sample that clients received.
        faults: Faults of the sensor by kind.
    """

    tick: int
    truth: Sample[T] | None
    arrived: Sample[T] | None
    faults: Mapping[str, SensorFault]


class Check(Stateful, ABC, Generic[S]):
    """A check of a fault by observations of type S, one in each tick."""

    @abstractmethod
    def observe(self, seen: S) -> None:
        """Update with the observation of a tick."""

    @property
    @abstractmethod
    def is_confirmed(self) -> bool:
        """Whether the effect of the fault is confirmed."""

    @abstractmethod
    def summary(self) -> str:
        """Return a text with the measured values."""


SensorCheck = Check[Observation[Any]]
"""A check of a fault of a sensor."""

Checking = tuple[Check[Any], Callable[[int], Any]]
"""A check, and the function that makes the observation of a tick."""


class Pairing(Stateful, Generic[T]):
    """Pairs received samples with the true ones."""

    STATE = ("_truths",)

    def __init__(self) -> None:
        self._truths: dict[int, T] = {}

    def pair(self, seen: Observation[T]) -> tuple[T, T] | None:
        """Update with a tick; returns the true and the received data of the sample that arrived in it."""
        if seen.truth is not None:
            self._truths[seen.truth.tick] = seen.truth.data
            if len(self._truths) > MOST_TRUTHS:
                del self._truths[next(iter(self._truths))]
        if seen.arrived is None or seen.arrived.tick not in self._truths:
            return None
        return self._truths.pop(seen.arrived.tick), seen.arrived.data


def delay_of(faults: Mapping[str, SensorFault]) -> float:
    """Return the delay of samples by the faults [s]."""
    delay = faults.get("delay")
    return delay.time if isinstance(delay, Delay) else 0.0
