"""The joints and the gripper of an arm, which are held where they are when they lose their power.

So it is with industrial arms, whose brakes hold them, and with grippers that have a self-locking gear: what they
have gripped stays gripped.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from seoro.bridges.wire import PowerLoss, WheelSlip
from sim_nodes.commands import Commanded
from sim_nodes.faults.check import Check
from sim_nodes.faults.drives import Drive, Identity
from sim_nodes.noise import Noise
from sim_nodes.ticks import TICK

STANDSTILL = 0.1  # [s]


class Powered(Protocol):
    """What moves of an arm, as far as its power is concerned. Joints are in rad, the gripper is in m."""

    wanted: float  # speed with which the fastest part was to move in the last tick [rad/s, m/s]

    def power(self, on: bool) -> None:
        """Cut off the power, or bring it back."""

    def moving(self) -> float:
        """Speed of the part that moves fastest [rad/s, m/s]."""


@dataclass(frozen=True)
class Kind:
    """A kind of what moves.

    Args:
        identity: What it is called.
        part: One part of it, in words.
        unit: Of its ways.
        standing: Speed up to which it stands still.
        behind: Way that it has to be behind what it was to move; with power, less is.
        is_stopped_by_things: Whether standing still means nothing where it is not to move: so it is with fingers,
            which are behind when they touch what they are to grip.
    """

    identity: Identity
    part: str
    unit: str
    standing: float
    behind: float
    is_stopped_by_things: bool


JOINTS = Kind(Identity("joints", "the joints", 0.5), "a joint", "rad", 0.01, 0.03, is_stopped_by_things=False)
GRIPPER = Kind(Identity("gripper", "the fingers", 0.05), "a finger", "m", 2e-3, 5e-4, is_stopped_by_things=True)


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
        unit = self._kind.unit
        return (
            f"{self._kind.part} was to move by {self._wanted:.3f} {unit}, none moved by more than "
            f"{self._moved:.3f} {unit}, and all have stood still for {self._ticks * TICK:.2f} s"
        )


class Actuators(Drive):
    """The joints or the gripper of an arm.

    Args:
        kind: Which of them.
        powered: They themselves.
        motors: What they command.
        noise: Gives the source of the random numbers of a purpose.
    """

    def __init__(
        self, kind: Kind, powered: Powered, motors: Commanded[Any], noise: Callable[[str], Noise]
    ) -> None:
        super().__init__(kind.identity, motors, noise)
        self._kind = kind
        self._powered = powered

    def apply(self) -> None:
        """See `Drive`."""
        self._powered.power(self.has_power)

    @property
    def is_at_rest(self) -> bool:
        """See `Drive`."""
        return self._powered.moving() <= self._kind.standing

    def begin_own(self, fault: WheelSlip | PowerLoss) -> Check:
        """See `Drive`."""
        return StandstillCheck(self._kind)

    def measure_own(self, check: Check) -> None:
        """See `Drive`."""
        assert isinstance(check, StandstillCheck)
        check.observe(self._powered.wanted, self._powered.moving())
