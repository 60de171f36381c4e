"""Loss of power of the joints and the gripper of an arm, which are held where they are then.

So it is with industrial arms, whose brakes hold them, and with grippers that have a self-locking gear: what they
have gripped stays gripped.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from seoro.bridges.wire import Fault, PowerLoss
from sim_nodes.faults.check import Check
from sim_nodes.faults.devices import Drive, cannot_have
from sim_nodes.ticks import TICK

STANDSTILL = 0.1  # [s]


class Powered(Protocol):
    """Something of an arm that moves, as far as its power is concerned. Joints are in rad, the gripper is in m."""

    wanted: float  # speed with which the fastest part was to move in the last tick [rad/s, m/s]

    def power(self, on: bool) -> None:
        """Cut off its power, or bring it back."""

    def moving(self) -> float:
        """Speed of the part that moves fastest [rad/s, m/s]."""


@dataclass(frozen=True)
class Kind:
    """A kind of what moves.

    Args:
        device: Its name among the devices.
        parts: What moves, in words, and one of it.
        unit: Of its ways.
        standing: Speed up to which it stands still.
        behind: Way that it has to be behind what it was to move; with power, less is.
        is_stopped_by_things: Whether standing still means nothing where it is not to move: so it is with fingers,
            which are behind when they touch what they are to grip.
    """

    device: str
    parts: tuple[str, str]
    unit: str
    standing: float
    behind: float
    is_stopped_by_things: bool


JOINTS = Kind("joints", ("the joints", "a joint"), "rad", 0.01, 0.03, is_stopped_by_things=False)
GRIPPER = Kind("gripper", ("the fingers", "a finger"), "m", 2e-3, 5e-4, is_stopped_by_things=True)


class StandstillCheck(Check):
    """Whether something stands still while it is to move.

    Args:
        kind: Its kind.
    """

    STATE = ("_wanted", "_moved", "_ticks")

    def __init__(self, kind: Kind) -> None:
        self._kind = kind
        self._wanted = 0.0  # way that the fastest part was to move
        self._moved = 0.0  # way that the fastest part has moved
        self._ticks = 0  # of standstill, in a row

    def observe(self, wanted: float, moving: float) -> None:
        """Take in a tick: the speeds with which the fastest parts were to move, and do."""
        self._wanted += wanted * TICK
        self._moved += moving * TICK
        counts = wanted > 0.0 or not self._kind.is_stopped_by_things
        self._ticks = self._ticks + 1 if counts and moving <= self._kind.standing else 0

    @property
    def holds(self) -> bool:
        """Whether it does."""
        return self._ticks * TICK >= STANDSTILL and self._wanted - self._moved >= self._kind.behind

    def figures(self) -> str:
        """How far it has come, and how long it has stood still."""
        unit, (_, one) = self._kind.unit, self._kind.parts
        return (
            f"{one} was to move by {self._wanted:.3f} {unit}, none moved by more than {self._moved:.3f} {unit}, "
            f"and all have stood still for {self._ticks * TICK:.2f} s"
        )


class Actuators(Drive):
    """The joints or the gripper of an arm.

    Args:
        kind: Which of them.
        powered: They themselves.
    """

    STATE = ("_is_off", "_has_supply")

    def __init__(self, kind: Kind, powered: Powered) -> None:
        self._kind = kind
        self._powered = powered
        self._is_off = False
        self._has_supply = True

    @property
    def kinds(self) -> Sequence[str]:
        """See `Device`."""
        return ("power_loss",) if self._is_off else ()

    def check(self, fault: Fault) -> None:
        """See `Device`."""
        if not isinstance(fault, PowerLoss):
            raise cannot_have(self._kind.device, fault, "only power_loss is possible")

    def put(self, fault: Fault) -> None:
        """See `Device`."""
        self._is_off = True
        self._apply()

    def lift(self, kind: str) -> None:
        """See `Device`."""
        if self._is_off and kind == "power_loss":
            self._is_off = False
            self._apply()

    def supply(self, on: bool) -> None:
        """See `Drive`."""
        self._has_supply = on
        self._apply()

    def _apply(self) -> None:
        self._powered.power(self._has_supply and not self._is_off)

    @property
    def parts(self) -> str:
        """See `Drive`."""
        return self._kind.parts[0]

    @property
    def is_at_rest(self) -> bool:
        """See `Drive`."""
        return self._powered.moving() <= self._kind.standing

    def begin(self, fault: Fault) -> Check:
        """See `Device`."""
        return StandstillCheck(self._kind)

    def measure(self, check: Check, tick: int) -> None:
        """See `Device`."""
        assert isinstance(check, StandstillCheck)
        check.observe(self._powered.wanted, self._powered.moving())
