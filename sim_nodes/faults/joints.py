"""Loss of power of the joints of an arm, whose brakes hold them then, as those of industrial arms do."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from seoro.bridges.wire import Fault, PowerLoss, Result
from sim_nodes.faults.check import Check
from sim_nodes.faults.devices import Device
from sim_nodes.refusal import RequestRefused
from sim_nodes.ticks import TICK

STANDING = 0.01  # [rad/s] up to which an arm stands still
STANDSTILL = 0.1  # [s]
BEHIND = 0.03  # [rad] that the joints have to be behind what they were to move; those with power are less


class Joined(Protocol):
    """An arm, as far as its power is concerned."""

    wanted: float  # speed of the joint that was to move fastest in the last tick [rad/s]

    def power(self, on: bool) -> None:
        """Cut off its power, or bring it back."""

    def moving(self) -> float:
        """Speed of the joint that moves fastest [rad/s]."""


class StandstillCheck(Check):
    """Whether joints stand still that are to move."""

    STATE = ("_wanted", "_moved", "_ticks")

    def __init__(self) -> None:
        self._wanted = 0.0  # way that the fastest joint was to move [rad]
        self._moved = 0.0  # way that the fastest joint has moved [rad]
        self._ticks = 0  # of standstill, in a row

    def observe(self, wanted: float, moving: float) -> None:
        """Take in a tick: the speeds of the joints that were to move, and do move, fastest [rad/s]."""
        self._wanted += wanted * TICK
        self._moved += moving * TICK
        self._ticks = self._ticks + 1 if moving <= STANDING else 0

    @property
    def holds(self) -> bool:
        """Whether they do."""
        return self._ticks * TICK >= STANDSTILL and self._wanted - self._moved >= BEHIND

    def figures(self) -> str:
        """How far they have come, and how long they have stood still."""
        return (
            f"a joint was to move by {self._wanted:.3f} rad, none moved by more than {self._moved:.3f} rad, "
            f"and all have stood still for {self._ticks * TICK:.2f} s"
        )


class Joints(Device):
    """The joints of an arm.

    Args:
        arm: The arm.
    """

    STATE = ("_is_off",)

    def __init__(self, arm: Joined) -> None:
        self._arm = arm
        self._is_off = False

    @property
    def kinds(self) -> Sequence[str]:
        """See `Device`."""
        return ("power_loss",) if self._is_off else ()

    def check(self, fault: Fault) -> None:
        """See `Device`."""
        if not isinstance(fault, PowerLoss):
            raise RequestRefused(
                Result.OPERATION_FAILED, f"joints cannot have {fault.kind}: they can have power_loss"
            )

    def put(self, fault: Fault) -> None:
        """See `Device`."""
        self._is_off = True
        self._arm.power(False)

    def lift(self, kind: str) -> None:
        """See `Device`."""
        if self._is_off and kind == "power_loss":
            self._is_off = False
            self._arm.power(True)

    def begin(self, fault: Fault) -> Check:
        """See `Device`."""
        return StandstillCheck()

    def measure(self, check: Check, tick: int) -> None:
        """See `Device`."""
        assert isinstance(check, StandstillCheck)
        check.observe(self._arm.wanted, self._arm.moving())
