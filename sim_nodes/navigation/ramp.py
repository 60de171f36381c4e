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
        self.velocity = self.wanted = AT_REST

    def stop(self) -> None:
        """Stop at once, regardless of accelerations."""
        self.velocity = self.wanted = AT_REST

    def follow(self) -> Velocity:
        """Return the velocity from this tick on."""
        if self.wanted != self.velocity or self._drive.min_turning_radius:
            limit = self._drive.max_turn_rate
            wanted = self.wanted._replace(angular=min(max(self.wanted.angular, -limit), limit))
            self.velocity = self.velocity.towards(wanted, self._drive, TICK)
        if self._drive.min_turning_radius:
            linear = self.velocity.linear
            self.velocity = Velocity(linear, linear * self._curvature())
        return self.velocity

    def _curvature(self) -> float:
        """Return the curvature at which a car drives: the wanted one, or while it stops, the present one [1/m]."""
        source = self.wanted if self.wanted.linear else self.velocity
        most = 1.0 / self._drive.min_turning_radius
        return min(max(source.angular / source.linear, -most), most) if source.linear else 0.0
