"""Checks of faults: their common parts, and checks of samples that are lost, frozen, delayed, or missing.

A check compares what clients of a device receive with what a sound device would have given them. It runs until the
effect is confirmed. It never concludes that a fault has no effect, because that may appear later.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any, ClassVar, Generic, TypeVar

import numpy as np

from seoro.bridges.wire import Delay, MessageLoss, SensorFault
from seoro.deferred import dataclass
from sim_nodes.faults.statistics import MESSAGES, Tally
from sim_nodes.sensors.sensor_pipeline import Sample, Sensor
from sim_nodes.stateful import Stateful
from sim_nodes.ticks import TICK

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


IN_A_ROW = 5  # frozen, delayed or missing samples
SILENCE = 0.5  # [s] without a sample
STILL = 1e-6  # [m], [rad], [m/s^2], [rad/s] jitter at rest
ROUNDING = 1e-9


class MessageLossCheck(SensorCheck):
    """Checks that the share of lost samples is that of a fault.

    Args:
        fault: The fault.
        what: Word for samples.
    """

    STATE = ("_due", "_lost")

    def __init__(self, fault: MessageLoss, what: str = "samples") -> None:
        self._what = what
        self._probability = fault.probability
        self._due: dict[int, int] = {}  # ticks of samples that have not arrived, and when they count as lost
        self._lost = Tally(MESSAGES)

    def observe(self, seen: Observation[Any]) -> None:
        """Update with a tick."""
        if seen.truth is not None:
            self._due[seen.truth.tick] = seen.tick + round(delay_of(seen.faults) / TICK) + 1
        if seen.arrived is not None and self._due.pop(seen.arrived.tick, None) is not None:
            self._count(lost=False)
        for sample in [sample for sample, deadline in self._due.items() if deadline < seen.tick]:
            del self._due[sample]
            self._count(lost=True)

    def _count(self, *, lost: bool) -> None:
        p = self._probability
        self._lost.add(1, float(lost), p, 0.0, p * (1.0 - p))

    @property
    def is_confirmed(self) -> bool:
        """Whether the share fits the fault."""
        return self._lost.is_confirmed

    def summary(self) -> str:
        """Return a text with the share."""
        lost = self._lost
        return f"{lost.found:.0f} of {lost.count} {self._what} were lost; expected {lost.expected:.1f}"


def are_equal(sensor: Sensor[Any], first: Any, second: Any) -> bool:
    """Whether two samples of a sensor have equal data, except for jitter at rest."""
    one, other = sensor.values(first), sensor.values(second)
    if not one:
        return bool(first == second)
    return all(np.allclose(one[quantity], other[quantity], rtol=0.0, atol=STILL) for quantity in one)


class FreezeCheck(SensorCheck):
    """Checks that samples repeat although the measured values change.

    Args:
        are_equal: Compares the data of two samples.
        what: Word for samples.
    """

    STATE = ("_pairing", "_last", "_same")

    def __init__(self, are_equal: Callable[[Any, Any], bool], what: str) -> None:
        self._are_equal = are_equal
        self._what = what
        self._pairing: Pairing[Any] = Pairing()
        self._last: Any = None
        self._same = 0  # repeated samples in a row that should differ

    def observe(self, seen: Observation[Any]) -> None:
        """Update with a tick."""
        pair = self._pairing.pair(seen)
        if pair is None:
            return
        truth, data = pair
        if self._last is None or not self._are_equal(data, self._last):
            self._same = 0
        elif not self._are_equal(truth, data):
            self._same += 1
        self._last = data

    @property
    def is_confirmed(self) -> bool:
        """Whether the samples are frozen."""
        return self._same >= IN_A_ROW

    def summary(self) -> str:
        """Return a text with the number of repetitions."""
        return f"{self._same} {self._what} in a row repeated the one before, although the true ones differ"


class DelayCheck(SensorCheck):
    """Checks that samples have the age of a delay when they arrive.

    Args:
        fault: The fault.
        what: Word for samples.
        period: Ticks between two samples that are observed.
    """

    STATE: ClassVar[tuple[str, ...]] = ("_late", "_age")

    def __init__(self, fault: Delay, what: str, period: int = 1) -> None:
        self._what = what
        self._period = period
        self._delay = fault.time
        self._late = 0  # delayed samples in a row
        self._age: float | None = None  # of the last sample [s]

    def observe(self, seen: Observation[Any]) -> None:
        """Update with a tick."""
        if seen.arrived is None:
            return
        self._age = (seen.tick - seen.arrived.tick) * TICK
        is_late = -ROUNDING <= self._age - self._delay < self._period * TICK
        self._late = self._late + 1 if is_late else 0

    @property
    def is_confirmed(self) -> bool:
        """Whether the samples are delayed as expected."""
        return self._late >= IN_A_ROW

    def summary(self) -> str:
        """Return a text with the age of the last sample."""
        if self._age is None:
            return f"no {self._what} have arrived"
        return (
            f"the last of the {self._what} was {self._age:.3g} s old, "
            f"and {self._late} in a row had the expected delay"
        )


class SilenceCheck(SensorCheck):
    """Checks that no samples arrive although they are due.

    Args:
        what: Word for samples.
    """

    STATE = ("_missed", "_since", "_silence")

    def __init__(self, what: str = "samples") -> None:
        self._what = what
        self._missed = 0
        self._since: int | None = None  # tick of the first missing sample
        self._silence = 0.0  # [s]

    def observe(self, seen: Observation[Any]) -> None:
        """Update with a tick."""
        if seen.arrived is not None:
            self._missed, self._since, self._silence = 0, None, 0.0
        elif seen.truth is not None:
            self._missed += 1
            self._since = seen.tick if self._since is None else self._since
            self._silence = (seen.tick - self._since) * TICK

    @property
    def is_confirmed(self) -> bool:
        """Whether all samples are missing."""
        return self._missed >= IN_A_ROW and self._silence >= SILENCE

    def summary(self) -> str:
        """Return a text with the duration."""
        return f"{self._missed} {self._what} in a row are missing, for {self._silence:.2f} s"
