"""What can have faults: sensors, the motors of wheels, and a robot as a whole."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from typing import Any, assert_never

from seoro.bridges.wire import (
    BeamLoss,
    Bias,
    DeadBeams,
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
from sim_nodes.faults.arrivals import SilenceCheck, arrival_check
from sim_nodes.faults.check import Check, Observation, SensorCheck
from sim_nodes.faults.fitting import check_fault, check_slip
from sim_nodes.faults.motors import Motion, MotorCheck, RestCheck, motor_check
from sim_nodes.faults.values import value_check
from sim_nodes.refusal import RequestRefused
from sim_nodes.robots.wheels import Wheels
from sim_nodes.sensors.feed import Feed
from sim_nodes.sensors.sensor import Sensor
from sim_nodes.stateful import Stateful

ReadMotion = Callable[[], Motion]
"""What the wheels of a robot do in the present tick."""


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


class SensorDevice(Device):
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
            raise _cannot_have(self._name, fault, "it has no wheels")
        check_fault(fault, self._name, self.feed.sensor)

    def put(self, fault: Fault) -> None:
        """See `Device`; whoever spoils a sensor uses it."""
        assert not isinstance(fault, WheelSlip)
        self.feed.put(fault)
        self.feed.in_use = True

    def lift(self, kind: str) -> None:
        """See `Device`."""
        self.feed.lift(kind)

    def begin(self, fault: Fault) -> Check:
        """See `Device`."""
        assert not isinstance(fault, WheelSlip)
        return sensor_check(fault, self.feed.sensor)

    def measure(self, check: Check, tick: int) -> None:
        """See `Device`."""
        assert isinstance(check, SensorCheck)
        check.observe(observation(self.feed, tick))


class Motors(Device):
    """The motors of the wheels.

    Args:
        wheels: The wheels.
        motion: Reads what they do.
    """

    STATE = ("_faults", "_has_supply")

    def __init__(self, wheels: Wheels, motion: ReadMotion) -> None:
        self._wheels = wheels
        self._motion = motion
        self._faults: dict[str, Fault] = {}
        self._has_supply = True

    @property
    def kinds(self) -> Sequence[str]:
        """See `Device`."""
        return tuple(self._faults)

    def check(self, fault: Fault) -> None:
        """See `Device`."""
        match fault:
            case WheelSlip():
                check_slip(fault)
            case PowerLoss():
                return
            case _:
                raise _cannot_have("motors", fault, "they can have wheel_slip and power_loss")

    def put(self, fault: Fault) -> None:
        """See `Device`."""
        self._faults[fault.kind] = fault
        self._apply()

    def lift(self, kind: str) -> None:
        """See `Device`."""
        if self._faults.pop(kind, None) is not None:
            self._apply()

    def supply(self, on: bool) -> None:
        """Cut off the supply of power, or bring it back."""
        self._has_supply = on
        self._apply()

    def _apply(self) -> None:
        slip = self._faults.get("wheel_slip")
        left, right = (slip.left, slip.right) if isinstance(slip, WheelSlip) else (0.0, 0.0)
        self._wheels.slip(left, right)
        self._wheels.power(self._has_supply and "power_loss" not in self._faults)

    def begin(self, fault: Fault) -> Check:
        """See `Device`."""
        assert isinstance(fault, WheelSlip | PowerLoss)
        return motor_check(fault)

    def measure(self, check: Check, tick: int) -> None:
        """See `Device`."""
        assert isinstance(check, MotorCheck)
        check.observe(self._motion())


class Blackout(Check):
    """Whether no sensor of a robot sends anything, and its wheels are at rest.

    Args:
        sensors: Names of the sensors.
        wheels: How many sets of wheels it has.
    """

    STATE = ("sensors", "wheels")

    def __init__(self, sensors: Sequence[str], wheels: int) -> None:
        self.sensors = {name: SilenceCheck() for name in sensors}
        self.wheels = [RestCheck() for _ in range(wheels)]

    @property
    def holds(self) -> bool:
        """Whether that is so."""
        return all(check.holds for check in (*self.sensors.values(), *self.wheels))

    def figures(self) -> str:
        """Of each sensor and the wheels."""
        told = [f"{name}: {check.figures()}" for name, check in self.sensors.items()]
        return "; ".join([*told, *(check.figures() for check in self.wheels)])


class WholeRobot(Device):
    """A robot as a whole: it can lose its power.

    Args:
        sensors: The ways of its sensors' samples, by the sensors' names.
        motors: Its motors, if it has some.
        motion: Reads what its wheels do.
    """

    STATE = ("_faults",)

    def __init__(self, sensors: Mapping[str, Feed[Any]], motors: Motors | None, motion: ReadMotion) -> None:
        self._sensors = sensors
        self._motors = motors
        self._motion = motion
        self._faults: dict[str, Fault] = {}

    @property
    def kinds(self) -> Sequence[str]:
        """See `Device`."""
        return tuple(self._faults)

    def check(self, fault: Fault) -> None:
        """See `Device`."""
        if not isinstance(fault, PowerLoss):
            raise _cannot_have("robot", fault, "it can have power_loss; others are those of its devices")

    def put(self, fault: Fault) -> None:
        """See `Device`."""
        self._faults[fault.kind] = fault
        self._supply(False)

    def lift(self, kind: str) -> None:
        """See `Device`."""
        if self._faults.pop(kind, None) is not None:
            self._supply(True)

    def _supply(self, on: bool) -> None:
        for feed in self._sensors.values():
            feed.supply(on)
            feed.in_use = True
        if self._motors is not None:
            self._motors.supply(on)

    def begin(self, fault: Fault) -> Check:
        """See `Device`."""
        return Blackout(tuple(self._sensors), 0 if self._motors is None else 1)

    def measure(self, check: Check, tick: int) -> None:
        """See `Device`."""
        assert isinstance(check, Blackout)
        for name, silence in check.sensors.items():
            silence.observe(observation(self._sensors[name], tick))
        for rest in check.wheels:
            rest.observe(self._motion())


def observation(feed: Feed[Any], tick: int) -> Observation[Any]:
    """What there was of a sensor in a tick."""
    return Observation(tick, feed.truth, feed.arrived, feed.faults)


def sensor_check(fault: SensorFault, sensor: Sensor[Any]) -> SensorCheck:
    """The measurement of a fault of a sensor."""
    match fault:
        case GaussianNoise() | Bias() | BeamLoss() | DeadSector() | DeadBeams():
            return value_check(fault, sensor)
        case MessageLoss() | Freeze() | Delay() | PowerLoss():
            return arrival_check(fault, sensor)
        case _:
            assert_never(fault)


def _cannot_have(device: str, fault: Fault, why: str) -> RequestRefused:
    return RequestRefused(Result.OPERATION_FAILED, f"{device} cannot have {fault.kind}: {why}")
