"""Limits of accelerations between decisions."""

from __future__ import annotations

from sim_nodes.robots.drive_declaration import DriveDeclaration
from sim_nodes.robots.kinematics import AT_REST, Velocity
from sim_nodes.stateful import Stateful
from sim_nodes.ticks import TICK


class Ramp(Stateful):
    """The velocity of a base, which follows the wanted one within the limits of its drive, tick by tick.

    Attributes:
        velocity: Present velocity.
        wanted: Wanted velocity.
    """

    STATE = ("velocity", "wanted")

    def __init__(self, drive: DriveDeclaration) -> None:
        self._drive = drive
        self._steps = drive.max_acceleration * TICK, drive.max_turn_acceleration * TICK
        self._limits = drive.max_turn_rate, drive.min_turning_radius
        self.velocity = self.wanted = AT_REST

    def stop(self) -> None:
        """Stop at once, regardless of accelerations."""
        self.velocity = self.wanted = AT_REST

    def follow(self) -> Velocity:
        """Return the velocity from this tick on."""
        (dv, dw), (limit, radius) = self._steps, self._limits
        wanted, (v, w, u) = self.wanted, self.velocity
        linear = min(max(wanted.linear, v - dv), v + dv)
        if radius:
            self.velocity = Velocity(linear, linear * self._curvature())
        elif wanted == self.velocity:
            self.velocity = wanted
        else:
            turn = min(max(wanted.angular, -limit), limit)
            self.velocity = Velocity(
                linear, min(max(turn, w - dw), w + dw), min(max(wanted.lateral, u - dv), u + dv)
            )
        return self.velocity

    def _curvature(self) -> float:
        """Return the curvature at which a car drives: the wanted one, or while it stops, the present one [1/m]."""
        source = self.wanted if self.wanted.linear else self.velocity
        most = 1.0 / self._drive.min_turning_radius
        return min(max(source.angular / source.linear, -most), most) if source.linear else 0.0
