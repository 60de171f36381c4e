"""The joints and the gripper of an arm, which hold their positions without power.

Brakes hold the joints of industrial arms; grippers have self-locking gears, which keep objects gripped.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from seoro.bridges.wire import Fault
from sim_nodes.faults.actuators import Actuator, ActuatorInfo, MotorGroup
from sim_nodes.faults.check import Check, Checking
from sim_nodes.noise import Noise
from sim_nodes.ticks import TICK

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

    def start_own_check(self, fault: Fault) -> Checking:
        """See `Actuator`."""
        powered = self._powered
        return StandstillCheck(self._kind), lambda _tick: (powered.commanded_speed, powered.fastest())
