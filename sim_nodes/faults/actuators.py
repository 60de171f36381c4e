"""Actuators with faults: the motors of wheels, of an arm's joints, and of a gripper.

Each can lose its power. Commands to motors pass through a pipeline as samples of sensors do, with the same faults
and checks.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import Any, Protocol, TypeVar

from seoro.bridges import wire
from seoro.deferred import dataclass
from sim_nodes.faults.checks import Check, Checking, Observation
from sim_nodes.faults.devices import Device, sensor_check
from sim_nodes.faults.motor_checks import AT_REST, Motion, SlipCheck, TorqueCheck
from sim_nodes.faults.validation import cannot_have, check_command_limit, check_fault, check_slip
from sim_nodes.geometry import Array
from sim_nodes.noise import Noise
from sim_nodes.robots.drive import Wheels
from sim_nodes.sensors.sensor_pipeline import Sensor, SensorPipeline, Values
from sim_nodes.ticks import TICK

T = TypeVar("T")

CommandFault = wire.GaussianNoise | wire.Bias | wire.MessageLoss | wire.Freeze | wire.Delay

ReadMotion = Callable[[], Motion]
"""Reads the motion of a robot's wheels in the present tick."""


class MotorGroup(Protocol[T]):
    """Motors with commands of type T."""

    @property
    def quantity(self) -> wire.Quantity:
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


class CommandSensor(Sensor[T]):
    """A sensor of the last command of motors, in every tick.

    Args:
        motors: The motors.
    """

    def __init__(self, motors: MotorGroup[T]) -> None:
        self._motors = motors
        self.quantities = (motors.quantity,)

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


MOTORS = ActuatorInfo("motors", "the wheels", 50.0)


class Actuator(Device):
    """A device that moves something while it has power.

    Args:
        info: Names of the actuator.
        motors: Its motors.
        noise: Factory of noise sources by purpose.
    """

    STATE = ("_own", "_has_supply", "_pipeline")

    def __init__(self, info: ActuatorInfo, motors: MotorGroup[Any], noise: Callable[[str], Noise]) -> None:
        self.info = info
        self._motors = motors
        self._pipeline: SensorPipeline[Any] = SensorPipeline(CommandSensor(motors), noise, always=True)
        self._own: dict[str, wire.Fault] = {}  # faults outside of the command pipeline, by kind
        self._has_supply = True

    @abstractmethod
    def apply(self) -> None:
        """Apply the faults outside of the command pipeline."""

    @abstractmethod
    def start_own_check(self, fault: wire.Fault) -> Checking:
        """Return a new check of a fault outside of the command pipeline."""

    @property
    @abstractmethod
    def is_at_rest(self) -> bool:
        """Whether its parts are at rest now."""

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

    def check(self, fault: wire.Fault) -> None:
        """See `Device`."""
        if isinstance(fault, CommandFault):
            check_fault(fault, self.info.device, self._pipeline.sensor)
            check_command_limit(fault, self.info.most)
        elif not isinstance(fault, wire.PowerLoss):
            raise cannot_have(self.info.device, fault)

    def add_fault(self, fault: wire.Fault) -> None:
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

    def start_check(self, fault: wire.Fault) -> Checking:
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
        super().__init__(MOTORS, wheels, noise)
        self._wheels = wheels
        self._motion = motion

    def apply(self) -> None:
        """See `Actuator`."""
        slip = self._own.get("wheel_slip")
        left, right = (slip.left, slip.right) if isinstance(slip, wire.WheelSlip) else (0.0, 0.0)
        self._wheels.slip(left, right)
        self._wheels.set_power(self.has_power)

    def check(self, fault: wire.Fault) -> None:
        """See `Device`."""
        if isinstance(fault, wire.WheelSlip):
            check_slip(fault)
        else:
            super().check(fault)

    @property
    def is_at_rest(self) -> bool:
        """See `Actuator`."""
        return max(map(abs, self._motion().turning)) <= AT_REST

    def start_own_check(self, fault: wire.Fault) -> Checking:
        """See `Actuator`."""
        check = SlipCheck(fault) if isinstance(fault, wire.WheelSlip) else TorqueCheck()
        return check, lambda _tick: self._motion()


STANDSTILL = 0.1  # [s]


class Powered(Protocol):
    """Joints [rad] or fingers [m] with a power supply."""

    commanded_speed: float  # commanded speed of the fastest part in the last tick [rad/s, m/s]

    def set_power(self, on: bool) -> None:
        """Switch the power supply."""

    def fastest(self) -> float:
        """Return the speed of the fastest part [rad/s, m/s]."""


@dataclass(frozen=True)
class ArmActuatorInfo(ActuatorInfo):
    """Names and thresholds of an actuator of an arm.

    Args:
        part: Text for one part.
        unit: Unit of positions.
        standing: Maximum speed at standstill.
        behind: Minimum lag behind the command that indicates a lack of power.
        is_stopped_by_things: Whether standstill without a commanded motion is normal. Fingers on an object lag
            behind.
    """

    part: str
    unit: str
    standing: float
    behind: float
    is_stopped_by_things: bool


JOINTS = ArmActuatorInfo("joints", "the joints", 0.5, "a joint", "rad", 0.01, 0.03, is_stopped_by_things=False)
GRIPPER = ArmActuatorInfo("gripper", "the fingers", 0.05, "a finger", "m", 2e-3, 5e-4, is_stopped_by_things=True)


class StandstillCheck(Check[tuple[float, float]]):
    """Checks that something stands still although it is commanded to move.

    Args:
        kind: Kind of actuator.
    """

    STATE = ("_wanted", "_moved", "_ticks")

    def __init__(self, kind: ArmActuatorInfo) -> None:
        self._kind = kind
        self._wanted = 0.0  # commanded distance of the fastest part
        self._moved = 0.0  # actual distance of the fastest part
        self._ticks = 0  # of standstill, in a row

    def observe(self, seen: tuple[float, float]) -> None:
        """Update with the commanded and actual speed of the fastest part in a tick."""
        commanded_speed, speed = seen
        self._wanted += commanded_speed * TICK
        self._moved += speed * TICK
        counts = commanded_speed > 0.0 or not self._kind.is_stopped_by_things
        self._ticks = self._ticks + 1 if counts and speed <= self._kind.standing else 0

    @property
    def is_confirmed(self) -> bool:
        """Whether the standstill is confirmed."""
        return self._ticks * TICK >= STANDSTILL and self._wanted - self._moved >= self._kind.behind

    def summary(self) -> str:
        """Return a text with distance and duration."""
        unit = self._kind.unit
        return (
            f"{self._kind.part} was commanded to move by {self._wanted:.3f} {unit}, none moved by more than "
            f"{self._moved:.3f} {unit}, and all have stood still for {self._ticks * TICK:.2f} s"
        )


class ArmActuator(Actuator):
    """The joints or the gripper of an arm.

    Args:
        kind: Kind of actuator.
        powered: Their power supply.
        motors: Their motors.
        noise: Factory of noise sources by purpose.
    """

    def __init__(
        self, kind: ArmActuatorInfo, powered: Powered, motors: MotorGroup[Any], noise: Callable[[str], Noise]
    ) -> None:
        super().__init__(kind, motors, noise)
        self._kind = kind
        self._powered = powered

    def apply(self) -> None:
        """See `Actuator`."""
        self._powered.set_power(self.has_power)

    @property
    def is_at_rest(self) -> bool:
        """See `Actuator`."""
        return self._powered.fastest() <= self._kind.standing

    def start_own_check(self, fault: wire.Fault) -> Checking:
        """See `Actuator`."""
        powered = self._powered
        return StandstillCheck(self._kind), lambda _tick: (powered.commanded_speed, powered.fastest())
