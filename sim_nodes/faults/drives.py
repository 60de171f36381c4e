"""What moves a robot, and can have faults: the motors of its wheels, of an arm's joints, of a gripper.

Each of them can lose its power. Commands come to motors as samples do from sensors, and are spoiled and measured
as these.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
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
    WheelSlip,
)
from sim_nodes.commands import Commanded, Orders
from sim_nodes.faults.check import Check, Observation, SensorCheck
from sim_nodes.faults.devices import Device, cannot_have, sensor_check
from sim_nodes.faults.fitting import check_fault, check_most, check_slip
from sim_nodes.faults.motors import AT_REST, Motion, MotorCheck, motor_check
from sim_nodes.noise import Noise
from sim_nodes.robots.wheels import PerWheel, Wheels
from sim_nodes.sensors.feed import Feed

MOST_SPEED = 50.0  # [rad/s] by which what wheels are told may be off

ReadMotion = Callable[[], Motion]
"""What the wheels of a robot do in the present tick."""


@dataclass(frozen=True)
class Identity:
    """What a drive is called.

    Args:
        device: Its name among the devices.
        parts: What it moves, in words.
        most: What its commands may be off by, in their unit.
    """

    device: str
    parts: str
    most: float


class Drive(Device):
    """A device that moves something, as long as it has power.

    Args:
        identity: What it is called.
        motors: What it commands.
        noise: Gives the source of the random numbers of a purpose.
    """

    STATE = ("_own", "_has_supply", "_way")

    def __init__(self, identity: Identity, motors: Commanded[Any], noise: Callable[[str], Noise]) -> None:
        self._identity = identity
        self._motors = motors
        self._way: Feed[Any] = Feed(Orders(motors), noise, always=True)
        self._own: dict[str, Fault] = {}  # faults that are not on the way of commands, by their kinds
        self._has_supply = True

    @abstractmethod
    def apply(self) -> None:
        """Let faults that are not on the way of commands take effect."""

    @abstractmethod
    def begin_own(self, fault: WheelSlip | PowerLoss) -> Check:
        """A new measurement of a fault that is not on the way of commands."""

    @abstractmethod
    def measure_own(self, check: Check) -> None:
        """Let such a measurement take in a tick."""

    @property
    @abstractmethod
    def is_at_rest(self) -> bool:
        """Whether what it moves is at rest now."""

    @property
    def parts(self) -> str:
        """What it moves, in words."""
        return self._identity.parts

    @property
    def has_power(self) -> bool:
        """Whether it has power."""
        return self._has_supply and "power_loss" not in self._own

    def supply(self, on: bool) -> None:
        """Cut off the supply of power, or bring it back."""
        self._has_supply = on
        self.apply()

    @property
    def is_busy(self) -> bool:
        """Whether it has something to do in every tick."""
        return bool(self._way.faults)

    def pass_tick(self, tick: int) -> None:
        """Let commands come, if there is a fault on their way."""
        if self.is_busy:
            self._way.pass_tick(tick)
            if self._way.arrived is not None:
                self._motors.tell(self._way.arrived.data)

    @property
    def kinds(self) -> Sequence[str]:
        """See `Device`."""
        return (*self._own, *self._way.faults)

    def check(self, fault: Fault) -> None:
        """See `Device`."""
        device = self._identity.device
        match fault:
            case GaussianNoise() | Bias() | MessageLoss() | Freeze() | Delay():
                check_fault(fault, device, self._way.sensor)
                check_most(fault, self._identity.most)
            case BeamLoss() | DeadSector() | DeadBeams():
                raise cannot_have(device, fault, "there are no beams")
            case DeadPixels() | DeadArea():
                raise cannot_have(device, fault, "there are no pixels")
            case WheelSlip():
                self.check_slip(fault)
            case PowerLoss():
                return
            case _:
                assert_never(fault)

    def check_slip(self, fault: WheelSlip) -> None:
        """Refuse slip, if there is no such."""
        raise cannot_have(self._identity.device, fault, "there are no wheels")

    def put(self, fault: Fault) -> None:
        """See `Device`."""
        match fault:
            case GaussianNoise() | Bias() | MessageLoss() | Freeze() | Delay():
                self._way.put(fault)
                self._motors.direct(False)
            case _:
                self._own[fault.kind] = fault
                self.apply()

    def lift(self, kind: str) -> None:
        """See `Device`."""
        if kind in self._way.faults:
            self._way.lift(kind)
            if not self.is_busy:
                self._motors.direct(True)
        if self._own.pop(kind, None) is not None:
            self.apply()

    def begin(self, fault: Fault) -> Check:
        """See `Device`."""
        if isinstance(fault, WheelSlip | PowerLoss):
            return self.begin_own(fault)
        assert not isinstance(fault, DeadPixels | DeadArea)
        return sensor_check(fault, self._way.sensor, "commands")

    def measure(self, check: Check, tick: int) -> None:
        """See `Device`."""
        if isinstance(check, SensorCheck):
            check.observe(Observation(tick, self._way.truth, self._way.arrived, self._way.faults))
        else:
            self.measure_own(check)


class WheelMotors(Drive):
    """The motors of the wheels.

    Args:
        wheels: The wheels.
        motion: Reads what they do.
        noise: Gives the source of the random numbers of a purpose.
    """

    def __init__(self, wheels: Wheels, motion: ReadMotion, noise: Callable[[str], Noise]) -> None:
        commanded: Commanded[PerWheel] = wheels
        super().__init__(Identity("motors", "the wheels", MOST_SPEED), commanded, noise)
        self._wheels = wheels
        self._motion = motion

    def apply(self) -> None:
        """See `Drive`."""
        slip = self._own.get("wheel_slip")
        left, right = (slip.left, slip.right) if isinstance(slip, WheelSlip) else (0.0, 0.0)
        self._wheels.slip(left, right)
        self._wheels.power(self.has_power)

    def check_slip(self, fault: WheelSlip) -> None:
        """See `Drive`."""
        check_slip(fault)

    @property
    def is_at_rest(self) -> bool:
        """See `Drive`."""
        return max(map(abs, self._motion().turning)) <= AT_REST

    def begin_own(self, fault: WheelSlip | PowerLoss) -> Check:
        """See `Drive`."""
        return motor_check(fault)

    def measure_own(self, check: Check) -> None:
        """See `Drive`."""
        assert isinstance(check, MotorCheck)
        check.observe(self._motion())
