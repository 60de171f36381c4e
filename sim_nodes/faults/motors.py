"""Measuring faults of the motors of wheels: slip, and loss of power."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import assert_never

from seoro.bridges.wire import PowerLoss, WheelSlip
from sim_nodes.faults.check import Check
from sim_nodes.robots.wheels import PerWheel
from sim_nodes.ticks import TICK

LEAST_SLIP = 0.1  # that can be told from none
OFF_BY = 0.05  # that a slip may be; wheels with grip slip by up to 2 % in curves
WAY = 0.3  # [m] that a wheel has to turn
TURNED = 0.01  # [m] from which on a slip can be told
COMMANDED = 0.5  # [rad/s] from which on a wheel that stands still has no torque
STANDING = 0.1  # share of its command with which a wheel stands still
AT_REST = 0.2  # [rad/s]; wheels of a robot that stands tremble by half of it
STANDSTILL = 0.5  # [s]
SIDES = ("left", "right")


@dataclass(frozen=True)
class Motion:
    """What the wheels of a robot do in a tick, left and right.

    Attributes:
        told: Speeds that their motors are told [rad/s].
        turning: Speeds at which they turn on the floor [rad/s].
        counted: Speeds of the base at the wheels by what odometry says to those who use it [m/s]; None without it.
        moved: The same speeds as they really are [m/s].
    """

    told: PerWheel
    turning: PerWheel
    counted: PerWheel | None
    moved: PerWheel


class MotorCheck(Check):
    """A measurement of a fault of motors."""

    @abstractmethod
    def observe(self, seen: Motion) -> None:
        """Take in a tick."""


class SlipCheck(MotorCheck):
    """Whether a robot moves less than its odometry says, by a share of it."""

    STATE = ("_counted", "_moved")

    def __init__(self, fault: WheelSlip) -> None:
        self._slips = (fault.left, fault.right)
        self._counted = [0.0, 0.0]  # ways of the wheels by odometry, forwards or backwards [m]
        self._moved = [0.0, 0.0]  # the same ways in truth [m]

    def observe(self, seen: Motion) -> None:
        """Take in a tick."""
        if seen.counted is None:
            return
        for side in (0, 1):
            forwards = 1.0 if seen.counted[side] >= 0.0 else -1.0
            self._counted[side] += forwards * seen.counted[side] * TICK
            self._moved[side] += forwards * seen.moved[side] * TICK

    def _measured(self, side: int) -> float:
        return 1.0 - self._moved[side] / self._counted[side]

    @property
    def holds(self) -> bool:
        """Whether each wheel that is to slip does so by its share."""
        slipping = [side for side in (0, 1) if self._slips[side] > 0.0]
        return all(
            self._counted[side] >= WAY and abs(self._measured(side) - self._slips[side]) <= OFF_BY
            for side in slipping
        )

    def figures(self) -> str:
        """The shares."""
        if min(self._counted) < TURNED:
            return f"by odometry the wheels have turned {self._counted[0]:.2f} and {self._counted[1]:.2f} m"
        return ", ".join(
            f"the {SIDES[side]} wheel turned {self._counted[side]:.2f} m by odometry and moved "
            f"{self._moved[side]:.2f} m, a slip of {self._measured(side):.3f}, expected was {self._slips[side]:g}"
            for side in (0, 1)
        )


class TorqueCheck(MotorCheck):
    """Whether wheels stand still that are commanded to turn."""

    STATE = ("_ticks", "_turning")

    def __init__(self) -> None:
        self._ticks = 0  # in a row
        self._turning = (0.0, 0.0)  # [rad/s]

    def observe(self, seen: Motion) -> None:
        """Take in a tick."""
        self._turning = seen.turning
        driven = [side for side in (0, 1) if abs(seen.told[side]) >= COMMANDED]
        if not driven or any(abs(seen.turning[side]) > STANDING * abs(seen.told[side]) for side in driven):
            self._ticks = 0
        else:
            self._ticks += 1

    @property
    def holds(self) -> bool:
        """Whether they do."""
        return self._ticks * TICK >= STANDSTILL

    def figures(self) -> str:
        """For how long."""
        fastest = max(map(abs, self._turning))
        return (
            f"for {self._ticks * TICK:.2f} s wheels that were commanded to turn stood still, "
            f"and at last none turned faster than {fastest:.2f} rad/s"
        )


MotorFault = WheelSlip | PowerLoss


def motor_check(fault: MotorFault) -> MotorCheck:
    """The measurement of a fault of motors."""
    match fault:
        case WheelSlip():
            return SlipCheck(fault)
        case PowerLoss():
            return TorqueCheck()
        case _:
            assert_never(fault)
