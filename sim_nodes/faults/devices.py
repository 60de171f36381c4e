"""What can have faults: what all of it has in common, and sensors."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any, assert_never

from seoro.bridges.wire import (
    BeamLoss,
    Bias,
    DeadArea,
    DeadBeams,
    DeadPixels,
    DeadSector,
    Delay,
    Fault,
    Freeze,
    GaussianNoise,
    MessageLoss,
    PowerLoss,
    Result,
    SensorFault,
    WheelSlip,
)
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.faults.arrivals import arrival_check
from sim_nodes.faults.check import Check, Observation, SensorCheck
from sim_nodes.faults.fitting import check_fault
from sim_nodes.faults.values import value_check
from sim_nodes.sensors.feed import Feed
from sim_nodes.sensors.sensor import Sensor
from sim_nodes.stateful import Stateful


class Device(Stateful, ABC):
    """Something that can have faults, one of each kind."""

    @property
    @abstractmethod
    def kinds(self) -> Sequence[str]:
        """The kinds of the faults that it has."""

    @abstractmethod
    def check(self, fault: Fault) -> None:
        """Refuse a fault that it cannot have.

        Raises:
            RequestRefused: The message says why.
        """

    @abstractmethod
    def put(self, fault: Fault) -> None:
        """Let it have a fault, in the place of another of its kind; it was checked."""

    @abstractmethod
    def lift(self, kind: str) -> None:
        """Take a fault from it, if it has one of the kind."""

    @abstractmethod
    def begin(self, fault: Fault) -> Check:
        """A new measurement of a fault that it has."""

    @abstractmethod
    def measure(self, check: Check, tick: int) -> None:
        """Let a measurement of its own take in a tick."""


class Source(Device):
    """A device that others get something from, as long as it has power."""

    @abstractmethod
    def supply(self, on: bool) -> None:
        """Cut off the supply of power, or bring it back."""

    @abstractmethod
    def observation(self, tick: int) -> Observation[Any]:
        """What there was of it in a tick."""


class SensorDevice(Source):
    """A sensor; its faults are those of the way of its samples.

    Args:
        name: Its name.
        feed: The way of its samples.
    """

    def __init__(self, name: str, feed: Feed[Any]) -> None:
        self._name = name
        self.feed = feed

    @property
    def kinds(self) -> Sequence[str]:
        """See `Device`."""
        return tuple(self.feed.faults)

    def check(self, fault: Fault) -> None:
        """See `Device`."""
        if isinstance(fault, WheelSlip):
            raise cannot_have(self._name, fault, "it has no wheels")
        if isinstance(fault, DeadPixels | DeadArea):
            raise cannot_have(self._name, fault, "it has no pixels")
        check_fault(fault, self._name, self.feed.sensor)

    def put(self, fault: Fault) -> None:
        """See `Device`; whoever spoils a sensor uses it."""
        assert not isinstance(fault, WheelSlip | DeadPixels | DeadArea)
        self.feed.put(fault)
        self.feed.in_use = True

    def supply(self, on: bool) -> None:
        """See `Source`; whoever cuts it off uses it."""
        self.feed.supply(on)
        self.feed.in_use = True

    def observation(self, tick: int) -> Observation[Any]:
        """See `Source`."""
        return Observation(tick, self.feed.truth, self.feed.arrived, self.feed.faults)

    def lift(self, kind: str) -> None:
        """See `Device`."""
        self.feed.lift(kind)

    def begin(self, fault: Fault) -> Check:
        """See `Device`."""
        assert not isinstance(fault, WheelSlip | DeadPixels | DeadArea)
        return sensor_check(fault, self.feed.sensor)

    def measure(self, check: Check, tick: int) -> None:
        """See `Device`."""
        assert isinstance(check, SensorCheck)
        check.observe(self.observation(tick))


def sensor_check(fault: SensorFault, sensor: Sensor[Any], what: str = "samples") -> SensorCheck:
    """The measurement of a fault of a sensor, whose samples are called something."""
    match fault:
        case GaussianNoise() | Bias() | BeamLoss() | DeadSector() | DeadBeams():
            return value_check(fault, sensor)
        case MessageLoss() | Freeze() | Delay() | PowerLoss():
            return arrival_check(fault, sensor, what)
        case _:
            assert_never(fault)


def cannot_have(device: str, fault: Fault, why: str) -> RequestRefused:
    """The refusal of a fault that makes no sense for a device."""
    return RequestRefused(Result.OPERATION_FAILED, f"{device} cannot have {fault.kind}: {why}")
