"""Keyframes of MJCF files as postures of robots."""

from __future__ import annotations

from collections.abc import Mapping

from seoro.deferred import dataclass
from sim_nodes.robots.derive.jointed import DerivedJoints
from sim_nodes.robots.derive.motors import limits_of
from sim_nodes.robots.postures import MAX_POSTURES, Posture, postures_form

HOME = "home"


@dataclass(frozen=True)
class Keyframes:
    """Named keyframes: positions by joint [rad], [m], by name."""

    positions: Mapping[str, Mapping[str, float]]

    @property
    def home(self) -> Mapping[str, float]:
        """Initial positions by joint: those of the keyframe `home`, else of the only one, else none."""
        if HOME in self.positions or len(self.positions) != 1:
            return self.positions.get(HOME, {})
        return next(iter(self.positions.values()))

    def postures(self, derived: DerivedJoints) -> dict[str, dict[str, float]]:
        """Return the keyframes as postures, within the limits of the joints, as the content of a file."""
        found = []
        for name, positions in self.positions.items():
            given = {}
            for joint in (each for each in derived.moved if each.name in positions):
                lower, upper = limits_of(joint)
                given[joint.name] = min(max(positions[joint.name], lower), upper)
            if given:
                found.append(Posture(name=name[:MAX_NAME], positions=tuple(given.items())))
        return postures_form(found[:MAX_POSTURES])


MAX_NAME = 100
