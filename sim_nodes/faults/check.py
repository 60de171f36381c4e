"""What all measurements of faults have in common.

A measurement holds what those who use a device have got against what a sound device would have given them. It
goes on until it is conclusive; it never concludes that a fault has no effect, since more may come of it later.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from seoro.bridges.wire import Delay, SensorFault
from sim_nodes.sensors.sensor import Sample
from sim_nodes.stateful import Stateful

T = TypeVar("T")

MOST_TRUTHS = 1000  # that are kept for samples which have not arrived


@dataclass(frozen=True)
class Observation(Generic[T]):
    """What there was of a sensor in a tick.

    Attributes:
        tick: The tick.
        truth: What a sound sensor would have sent.
        arrived: What those who use it have got.
        faults: The faults that lie on it, by their kinds.
    """

    tick: int
    truth: Sample[T] | None
    arrived: Sample[T] | None
    faults: Mapping[str, SensorFault]


class Check(Stateful, ABC):
    """A measurement of a fault."""

    @property
    @abstractmethod
    def holds(self) -> bool:
        """Whether the fault has been found to take effect."""

    @abstractmethod
    def figures(self) -> str:
        """What has been measured, in words."""


class SensorCheck(Check):
    """A measurement of a fault of a sensor."""

    @abstractmethod
    def observe(self, seen: Observation[Any]) -> None:
        """Take in a tick."""


@dataclass(frozen=True)
class Pair(Generic[T]):
    """Data as they arrived, and as a sound sensor would have sent them, of the same tick."""

    truth: T
    data: T


class Pairing(Stateful, Generic[T]):
    """Finds what a sound sensor would have sent in the place of a sample that arrives."""

    STATE = ("_truths",)

    def __init__(self) -> None:
        self._truths: dict[int, T] = {}

    def pair(self, seen: Observation[T]) -> Pair[T] | None:
        """Take in a tick; returns the pair of the sample that has arrived in it."""
        if seen.truth is not None:
            self._truths[seen.truth.tick] = seen.truth.data
            if len(self._truths) > MOST_TRUTHS:
                del self._truths[next(iter(self._truths))]
        if seen.arrived is None or seen.arrived.tick not in self._truths:
            return None
        return Pair(self._truths.pop(seen.arrived.tick), seen.arrived.data)


def delay_of(faults: Mapping[str, SensorFault]) -> float:
    """How late samples arrive by the faults [s]."""
    delay = faults.get("delay")
    return delay.time if isinstance(delay, Delay) else 0.0
