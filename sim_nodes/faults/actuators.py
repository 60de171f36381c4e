"""Actuators with faults: the motors of wheels, of an arm's joints, and of a gripper.

Each can lose its power. Commands to motors pass through a pipeline as samples of sensors do, with the same faults
and checks.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar

import numpy as np

from seoro.bridges.wire import (
    Bias,
    Delay,
    Fault,
    Freeze,
    GaussianNoise,
    MessageLoss,
    PowerLoss,
    Quantity,
    WheelSlip,
)
from sim_nodes.faults.check import Checking, Observation
from sim_nodes.faults.devices import Device, cannot_have, sensor_check
from sim_nodes.faults.motor_checks import AT_REST, Motion, SlipCheck, TorqueCheck
from sim_nodes.faults.validation import check_command_limit, check_fault, check_slip
from sim_nodes.geometry import Array
from sim_nodes.noise import Noise
from sim_nodes.robots.wheels import PerWheel, Wheels
from sim_nodes.sensors.sensor import Values
from sim_nodes.sensors.sensor_pipeline import SensorPipeline
from sim_nodes.stateful import Stateful

T = TypeVar("T")

CommandFault = GaussianNoise | Bias | MessageLoss | Freeze | Delay

MOST_SPEED = 50.0  # [rad/s] maximum error of wheel commands

ReadMotion = Callable[[], Motion]
"""Reads the motion of a robot's wheels in the present tick."""


class MotorGroup(Protocol[T]):
    """Motors with commands of type T."""

    @property
    def quantity(self) -> Quantity:
        """Quantity of the numbers of a command."""

    @property
    def command(self) -> T:
        """The last command."""

    def to_array(self, command: T) -> Array:
        """Return the numbers of a command, shape (n,)."""

    def with_array(self, command: T, numbers: Array) -> T:
        """Return the command with other numbers."""

    def set_passthrough(self, on: bool) -> None:
        """Choose whether commands reach the motors at once, or only through `apply_command`."""

    def apply_command(self, command: T) -> None:
        """Set the motor targets from a command."""


class CommandSensor(Stateful, Generic[T]):
    """A `Sensor` of the last command of motors, in every tick.

    Args:
        motors: The motors.
    """

    period = 1
    limits = (-math.inf, math.inf)
    bearings: Array = np.zeros(0)

    def __init__(self, motors: MotorGroup[T]) -> None:
        self._motors = motors

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """See `Sensor`."""
        return (self._motors.quantity,)

    def read(self, tick: int) -> T:
        """Return the last command."""
        return self._motors.command

    def values(self, data: T) -> Values:
        """Return the numbers of the command."""
        return {self._motors.quantity: self._motors.to_array(data)}

    def with_values(self, data: T, values: Values) -> T:
        """Return the command with other numbers."""
        return self._motors.with_array(data, values[self._motors.quantity])


@dataclass(frozen=True)
class ActuatorInfo:
    """Names of an actuator.

    Args:
        device: Name of the device.
        parts: Text for the parts that it moves.
        most: Maximum error of its commands, in their unit.
    """

    device: str
    parts: str
    most: float


class Actuator(Device):
    """A device that moves something while it has power.

    Args:
        identity: Names of the actuator.
        motors: Its motors.
        noise: Factory of noise sources by purpose.
    """

    STATE = ("_own", "_has_supply", "_pipeline")

    def __init__(self, identity: ActuatorInfo, motors: MotorGroup[Any], noise: Callable[[str], Noise]) -> None:
        self._identity = identity
        self._motors = motors
        self._pipeline: SensorPipeline[Any] = SensorPipeline(CommandSensor(motors), noise, always=True)
        self._own: dict[str, Fault] = {}  # faults outside of the command pipeline, by kind
        self._has_supply = True

    @abstractmethod
    def apply(self) -> None:
        """Apply the faults outside of the command pipeline."""

    @abstractmethod
    def start_own_check(self, fault: Fault) -> Checking:
        """Return a new check of a fault outside of the command pipeline."""

    @property
    @abstractmethod
    def is_at_rest(self) -> bool:
        """Whether its parts are at rest now."""

    @property
    def parts(self) -> str:
        """Text for the parts that it moves."""
        return self._identity.parts

    @property
    def has_power(self) -> bool:
        """Whether it has power."""
        return self._has_supply and "power_loss" not in self._own

    def set_power(self, on: bool) -> None:
        """Switch the power supply."""
        self._has_supply = on
        self.apply()

    @property
    def is_busy(self) -> bool:
        """Whether it needs every tick."""
        return bool(self._pipeline.faults)

    def update(self, tick: int) -> None:
        """Update the command pipeline, if it has faults."""
        if self.is_busy:
            self._pipeline.update(tick)
            if self._pipeline.arrived is not None:
                self._motors.apply_command(self._pipeline.arrived.data)

    @property
    def kinds(self) -> Sequence[str]:
        """See `Device`."""
        return (*self._own, *self._pipeline.faults)

    def check(self, fault: Fault) -> None:
        """See `Device`."""
        if isinstance(fault, CommandFault):
            check_fault(fault, self._identity.device, self._pipeline.sensor)
            check_command_limit(fault, self._identity.most)
        elif not isinstance(fault, PowerLoss):
            raise cannot_have(self._identity.device, fault)

    def add_fault(self, fault: Fault) -> None:
        """See `Device`."""
        if isinstance(fault, CommandFault):
            self._pipeline.add_fault(fault)
            self._motors.set_passthrough(False)
        else:
            self._own[fault.kind] = fault
            self.apply()

    def remove_fault(self, kind: str) -> None:
        """See `Device`."""
        if kind in self._pipeline.faults:
            self._pipeline.remove_fault(kind)
            if not self.is_busy:
                self._motors.set_passthrough(True)
        if self._own.pop(kind, None) is not None:
            self.apply()

    def start_check(self, fault: Fault) -> Checking:
        """See `Device`."""
        if not isinstance(fault, CommandFault):
            return self.start_own_check(fault)
        return sensor_check(fault, self._pipeline.sensor, "commands"), self._observation

    def _observation(self, tick: int) -> Observation[Any]:
        return Observation(tick, self._pipeline.truth, self._pipeline.arrived, self._pipeline.faults)


class WheelMotors(Actuator):
    """The motors of the wheels.

    Args:
        wheels: The wheels.
        motion: Reads their motion.
        noise: Factory of noise sources by purpose.
    """

    def __init__(self, wheels: Wheels, motion: ReadMotion, noise: Callable[[str], Noise]) -> None:
        commanded: MotorGroup[PerWheel] = wheels
        super().__init__(ActuatorInfo("motors", "the wheels", MOST_SPEED), commanded, noise)
        self._wheels = wheels
        self._motion = motion

    def apply(self) -> None:
        """See `Actuator`."""
        slip = self._own.get("wheel_slip")
        left, right = (slip.left, slip.right) if isinstance(slip, WheelSlip) else (0.0, 0.0)
        self._wheels.slip(left, right)
        self._wheels.set_power(self.has_power)

    def check(self, fault: Fault) -> None:
        """See `Device`."""
        if isinstance(fault, WheelSlip):
            check_slip(fault)
        else:
            super().check(fault)

    @property
    def is_at_rest(self) -> bool:
        """See `Actuator`."""
        return max(map(abs, self._motion().turning)) <= AT_REST

    def start_own_check(self, fault: Fault) -> Checking:
        """See `Actuator`."""
        check = SlipCheck(fault) if isinstance(fault, WheelSlip) else TorqueCheck()
        return check, lambda _tick: self._motion()
