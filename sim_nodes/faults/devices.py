"""What can have faults: sensors, and the motors of wheels."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
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
from sim_nodes.faults.arrivals import arrival_check
from sim_nodes.faults.check import Check, Observation, SensorCheck
from sim_nodes.faults.fitting import check_fault, check_slip, check_speeds
from sim_nodes.faults.motors import AT_REST, Motion, MotorCheck, motor_check
from sim_nodes.faults.values import value_check
from sim_nodes.noise import Noise
from sim_nodes.refusal import RequestRefused
from sim_nodes.robots.orders import Orders
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


class Drive(Device):
    """A device that moves something, as long as it has power."""

    @abstractmethod
    def supply(self, on: bool) -> None:
        """Cut off the supply of power, or bring it back."""

    @property
    @abstractmethod
    def parts(self) -> str:
        """What it moves, in words."""

    @property
    @abstractmethod
    def is_at_rest(self) -> bool:
        """Whether that is at rest now."""


class Motors(Drive):
    """The motors of the wheels.

    Args:
        wheels: The wheels.
        motion: Reads what they do.
        noise: Gives the source of the random numbers of a purpose.

    Commands come to motors as samples do from sensors, and are spoiled and measured as these.
    """

    STATE = ("_faults", "_has_supply", "_orders")

    def __init__(self, wheels: Wheels, motion: ReadMotion, noise: Callable[[str], Noise]) -> None:
        self._wheels = wheels
        self._motion = motion
        self._orders = Feed(Orders(wheels), noise, always=True)
        self._faults: dict[str, Fault] = {}
        self._has_supply = True

    @property
    def kinds(self) -> Sequence[str]:
        """See `Device`."""
        return (*self._faults, *self._orders.faults)

    @property
    def is_busy(self) -> bool:
        """Whether they have something to do in every tick."""
        return bool(self._orders.faults)

    def pass_tick(self, tick: int) -> None:
        """Let commands come, if there is a fault on their way."""
        if self.is_busy:
            self._orders.pass_tick(tick)
            if self._orders.arrived is not None:
                self._wheels.tell(*self._orders.arrived.data)

    def check(self, fault: Fault) -> None:
        """See `Device`."""
        match fault:
            case WheelSlip():
                check_slip(fault)
            case PowerLoss():
                return
            case GaussianNoise() | Bias() | MessageLoss() | Freeze() | Delay():
                check_fault(fault, "motors", self._orders.sensor)
                check_speeds(fault)
            case BeamLoss() | DeadSector() | DeadBeams():
                raise cannot_have("motors", fault, "they have no beams")
            case DeadPixels() | DeadArea():
                raise cannot_have("motors", fault, "they have no pixels")
            case _:
                assert_never(fault)

    def put(self, fault: Fault) -> None:
        """See `Device`."""
        match fault:
            case GaussianNoise() | Bias() | MessageLoss() | Freeze() | Delay():
                self._orders.put(fault)
                self._wheels.direct(False)
            case _:
                self._faults[fault.kind] = fault
                self._apply()

    def lift(self, kind: str) -> None:
        """See `Device`."""
        if kind in self._orders.faults:
            self._orders.lift(kind)
            if not self.is_busy:
                self._wheels.direct(True)
        if self._faults.pop(kind, None) is not None:
            self._apply()

    def supply(self, on: bool) -> None:
        """See `Drive`."""
        self._has_supply = on
        self._apply()

    @property
    def parts(self) -> str:
        """See `Drive`."""
        return "the wheels"

    @property
    def is_at_rest(self) -> bool:
        """See `Drive`."""
        return max(map(abs, self._motion().turning)) <= AT_REST

    def _apply(self) -> None:
        slip = self._faults.get("wheel_slip")
        left, right = (slip.left, slip.right) if isinstance(slip, WheelSlip) else (0.0, 0.0)
        self._wheels.slip(left, right)
        self._wheels.power(self._has_supply and "power_loss" not in self._faults)

    def begin(self, fault: Fault) -> Check:
        """See `Device`."""
        match fault:
            case WheelSlip() | PowerLoss():
                return motor_check(fault)
            case GaussianNoise() | Bias() | MessageLoss() | Freeze() | Delay():
                return sensor_check(fault, self._orders.sensor, "commands")
            case _:
                raise AssertionError(f"motors have no {fault.kind}")

    def measure(self, check: Check, tick: int) -> None:
        """See `Device`."""
        if isinstance(check, MotorCheck):
            check.observe(self._motion())
        else:
            assert isinstance(check, SensorCheck)
            orders = self._orders
            check.observe(Observation(tick, orders.truth, orders.arrived, orders.faults))


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
