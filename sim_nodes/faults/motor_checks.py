"""Checks of faults of wheel motors: slip and loss of power."""

from __future__ import annotations

from seoro.bridges.wire import WheelSlip
from seoro.deferred import dataclass
from sim_nodes.faults.checks import Check
from sim_nodes.robots.drive import PerMotor
from sim_nodes.ticks import TICK

LEAST_SLIP = 0.1  # smallest measurable slip
OFF_BY = 0.05  # tolerance of a slip; wheels with grip slip by up to 2 % in curves
WAY = 0.3  # [m] that a wheel must turn
TURNED = 0.01  # [m] of turning from which a slip can be computed
COMMANDED = 0.5  # [rad/s] command from which standstill indicates a lack of torque
STANDING = 0.1  # share of its command up to which a wheel stands still
AT_REST = 0.2  # [rad/s]; wheels of a standing robot jitter by half of it
STANDSTILL = 0.5  # [s]
SIDES = ("left", "right")


@dataclass(frozen=True)
class Motion:
    """Motion of a robot's wheels in a tick.

    Attributes:
        commanded: Speeds that reach the motors of the wheels [rad/s].
        turning: Speeds of the wheels relative to the floor [rad/s].
        odometry: Ground speeds at the left and right wheels by the odometry that clients receive [m/s]; None
            without odometry.
        actual: True ground speeds at the left and right wheels [m/s].
    """

    commanded: PerMotor
    turning: PerMotor
    odometry: tuple[float, float] | None
    actual: tuple[float, float]


class SlipCheck(Check[Motion]):
    """Checks that a robot moves less than its odometry states, by the share of a slip."""

    STATE = ("_counted", "_moved")

    def __init__(self, fault: WheelSlip) -> None:
        self._slips = (fault.left, fault.right)
        self._counted = [0.0, 0.0]  # signed distances of the wheels by odometry [m]
        self._moved = [0.0, 0.0]  # true signed distances [m]

    def observe(self, seen: Motion) -> None:
        """Update with a tick."""
        if seen.odometry is None:
            return
        for side in (0, 1):
            forwards = 1.0 if seen.odometry[side] >= 0.0 else -1.0
            self._counted[side] += forwards * seen.odometry[side] * TICK
            self._moved[side] += forwards * seen.actual[side] * TICK

    def _measured(self, side: int) -> float:
        return 1.0 - self._moved[side] / self._counted[side]

    @property
    def is_confirmed(self) -> bool:
        """Whether each slipping wheel has its share."""
        slipping = [side for side in (0, 1) if self._slips[side] > 0.0]
        return all(
            self._counted[side] >= WAY and abs(self._measured(side) - self._slips[side]) <= OFF_BY
            for side in slipping
        )

    def summary(self) -> str:
        """Return a text with the shares."""
        if min(self._counted) < TURNED:
            return f"by odometry the wheels have turned {self._counted[0]:.2f} and {self._counted[1]:.2f} m"
        return ", ".join(
            f"the {SIDES[side]} wheel turned {self._counted[side]:.2f} m by odometry and moved "
            f"{self._moved[side]:.2f} m, a slip of {self._measured(side):.3f}; expected {self._slips[side]:g}"
            for side in (0, 1)
        )


class TorqueCheck(Check[Motion]):
    """Checks that wheels stand still although they are commanded to turn."""

    STATE = ("_ticks", "_turning")

    def __init__(self) -> None:
        self._ticks = 0  # in a row
        self._turning: PerMotor = (0.0,)  # [rad/s]

    def observe(self, seen: Motion) -> None:
        """Update with a tick."""
        self._turning = seen.turning
        driven = [wheel for wheel, speed in enumerate(seen.commanded) if abs(speed) >= COMMANDED]
        if not driven or any(abs(seen.turning[at]) > STANDING * abs(seen.commanded[at]) for at in driven):
            self._ticks = 0
        else:
            self._ticks += 1

    @property
    def is_confirmed(self) -> bool:
        """Whether the standstill is confirmed."""
        return self._ticks * TICK >= STANDSTILL

    def summary(self) -> str:
        """Return a text with the duration."""
        fastest = max(map(abs, self._turning))
        return (
            f"for {self._ticks * TICK:.2f} s wheels that were commanded to turn stood still, "
            f"and at last none turned faster than {fastest:.2f} rad/s"
        )
