"""Speeds that a base can reduce within a way, and rates of turns in place."""

from __future__ import annotations

import math

from sim_nodes.robots.drive_declaration import DriveDeclaration

LATENCY = 0.2  # [s] from an obstacle's appearance to braking: scan, decision, wheels
STOP_MARGIN = 0.01  # [m] before an obstacle's clearance at which robots stop
TURN_GAIN = 2.5  # [1/s]; rate of turning in place by remaining angle
SLOWEST_TURN = 0.25  # [rad/s]
CALM = 0.5  # of the maximum acceleration for planned changes of speed


class Braking:
    """Braking of a base.

    Args:
        drive: Declaration of its drive.
    """

    def __init__(self, drive: DriveDeclaration) -> None:
        self._acceleration = drive.max_acceleration

    def room(self, speed: float) -> float:
        """Return the way to stop from a speed, with latency [m]."""
        return speed * LATENCY + speed**2 / (2.0 * self._acceleration)

    def speed(self, room: float) -> float:
        """Return the speed that needs a way to stop [m/s]; 0 without one."""
        a = self._acceleration
        return -a * LATENCY + math.sqrt((a * LATENCY) ** 2 + 2.0 * a * max(room, 0.0))

    def calm_speed(self, room: float) -> float:
        """Return the speed from which the base stops calmly within a way [m/s]."""
        return math.sqrt(2.0 * CALM * self._acceleration * max(room, 0.0))


def turn_rate(angle: float, limit: float) -> float:
    """Return the rate of a turn in place by a remaining angle [rad], up to a limit [rad/s]."""
    return max(min(TURN_GAIN * abs(angle), limit), min(SLOWEST_TURN, limit))
