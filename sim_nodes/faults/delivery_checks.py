"""Checks of delivery faults: samples that are lost, frozen, delayed, or missing."""

from __future__ import annotations

from typing import Any

import numpy as np

from seoro.bridges.wire import Delay, MessageLoss
from sim_nodes.faults.check import Observation, Pairing, SensorCheck, delay_of
from sim_nodes.faults.statistics import MESSAGES, Tally
from sim_nodes.sensors.sensor import Sensor
from sim_nodes.ticks import TICK

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


class FreezeCheck(SensorCheck):
    """Checks that samples repeat although the measured values change.

    Args:
        sensor: The sensor.
        what: Word for samples.
    """

    STATE = ("_pairing", "_last", "_same")

    def __init__(self, sensor: Sensor[Any], what: str) -> None:
        self._sensor = sensor
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

    def _are_equal(self, first: Any, second: Any) -> bool:
        one, other = self._sensor.values(first), self._sensor.values(second)
        if not one:
            return bool(first == second)
        return all(np.allclose(one[quantity], other[quantity], rtol=0.0, atol=STILL) for quantity in one)

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
    """

    STATE = ("_late", "_age")

    def __init__(self, fault: Delay, what: str) -> None:
        self._what = what
        self._delay = fault.time
        self._late = 0  # delayed samples in a row
        self._age: float | None = None  # of the last sample [s]

    def observe(self, seen: Observation[Any]) -> None:
        """Update with a tick."""
        if seen.arrived is None:
            return
        self._age = (seen.tick - seen.arrived.tick) * TICK
        is_late = -ROUNDING <= self._age - self._delay < TICK
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
