"""Measuring faults of how samples arrive: lost, frozen, late, none."""

from __future__ import annotations

from typing import Any, assert_never

import numpy as np

from seoro.bridges.wire import Delay, Freeze, MessageLoss, PowerLoss
from sim_nodes.faults.check import Observation, Pairing, SensorCheck, delay_of
from sim_nodes.faults.tally import MESSAGES, Tally
from sim_nodes.sensors.sensor import Sensor
from sim_nodes.ticks import TICK

IN_A_ROW = 5  # samples that are frozen, late or missing
SILENCE = 0.5  # [s] without a sample
STILL = 1e-6  # [m], [rad], [m/s^2], [rad/s] by which things at rest tremble
ROUNDING = 1e-9


class MessageLossCheck(SensorCheck):
    """Whether the share of samples that do not arrive is that of a fault.

    Args:
        fault: The fault.
        what: What samples are called.
    """

    STATE = ("_due", "_lost")

    def __init__(self, fault: MessageLoss, what: str = "samples") -> None:
        self._what = what
        self._probability = fault.probability
        self._due: dict[int, int] = {}  # ticks of samples that have not arrived, and when they are lost
        self._lost = Tally(MESSAGES)

    def observe(self, seen: Observation[Any]) -> None:
        """Take in a tick."""
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
    def holds(self) -> bool:
        """Whether the share is that of the fault."""
        return self._lost.holds

    def figures(self) -> str:
        """The share."""
        lost = self._lost
        return f"{lost.found:.0f} of {lost.count} {self._what} were lost, expected were {lost.expected:.1f}"


class FreezeCheck(SensorCheck):
    """Whether samples are the same, though what is sensed is not.

    Args:
        sensor: What gives them.
        what: What they are called.
    """

    STATE = ("_pairing", "_last", "_same")

    def __init__(self, sensor: Sensor[Any], what: str) -> None:
        self._sensor = sensor
        self._what = what
        self._pairing: Pairing[Any] = Pairing()
        self._last: Any = None
        self._same = 0  # samples in a row that are like those before, and should not be

    def observe(self, seen: Observation[Any]) -> None:
        """Take in a tick."""
        pair = self._pairing.pair(seen)
        if pair is None:
            return
        if self._last is None or not self._alike(pair.data, self._last):
            self._same = 0
        elif not self._alike(pair.truth, pair.data):
            self._same += 1
        self._last = pair.data

    def _alike(self, first: Any, second: Any) -> bool:
        one, other = self._sensor.values(first), self._sensor.values(second)
        if not one:
            return bool(first == second)
        return all(np.allclose(one[quantity], other[quantity], rtol=0.0, atol=STILL) for quantity in one)

    @property
    def holds(self) -> bool:
        """Whether they are."""
        return self._same >= IN_A_ROW

    def figures(self) -> str:
        """How many."""
        return f"{self._same} {self._what} in a row were as the one before, where sound ones would have differed"


class DelayCheck(SensorCheck):
    """Whether samples are as old as a delay when they arrive.

    Args:
        fault: The fault.
        what: What samples are called.
    """

    STATE = ("_late", "_age")

    def __init__(self, fault: Delay, what: str) -> None:
        self._what = what
        self._delay = fault.time
        self._late = 0  # samples in a row
        self._age: float | None = None  # of the last one [s]

    def observe(self, seen: Observation[Any]) -> None:
        """Take in a tick."""
        if seen.arrived is None:
            return
        self._age = (seen.tick - seen.arrived.tick) * TICK
        is_late = -ROUNDING <= self._age - self._delay < TICK
        self._late = self._late + 1 if is_late else 0

    @property
    def holds(self) -> bool:
        """Whether they are."""
        return self._late >= IN_A_ROW

    def figures(self) -> str:
        """How old the last one was."""
        if self._age is None:
            return f"no {self._what} have arrived"
        return (
            f"the last of the {self._what} was {self._age:.3g} s old, "
            f"and {self._late} in a row as late as they should be"
        )


class SilenceCheck(SensorCheck):
    """Whether no samples arrive, though they are due.

    Args:
        what: What samples are called.
    """

    STATE = ("_missed", "_since", "_silence")

    def __init__(self, what: str = "samples") -> None:
        self._what = what
        self._missed = 0
        self._since: int | None = None  # tick of the first that was missed
        self._silence = 0.0  # [s]

    def observe(self, seen: Observation[Any]) -> None:
        """Take in a tick."""
        if seen.arrived is not None:
            self._missed, self._since, self._silence = 0, None, 0.0
        elif seen.truth is not None:
            self._missed += 1
            self._since = seen.tick if self._since is None else self._since
            self._silence = (seen.tick - self._since) * TICK

    @property
    def holds(self) -> bool:
        """Whether none do."""
        return self._missed >= IN_A_ROW and self._silence >= SILENCE

    def figures(self) -> str:
        """For how long."""
        return f"{self._missed} {self._what} in a row have not arrived, in {self._silence:.2f} s"


ArrivalFault = MessageLoss | Freeze | Delay | PowerLoss


def arrival_check(fault: ArrivalFault, sensor: Sensor[Any], what: str) -> SensorCheck:
    """The measurement of a fault of how samples arrive, which are called something."""
    match fault:
        case MessageLoss():
            return MessageLossCheck(fault, what)
        case Freeze():
            return FreezeCheck(sensor, what)
        case Delay():
            return DelayCheck(fault, what)
        case PowerLoss():
            return SilenceCheck(what)
        case _:
            assert_never(fault)
