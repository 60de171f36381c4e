"""Bumper: its pressed zones, with entities and times."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from seoro.bridges.wire import Quantity
from sim_nodes.geometry import Array, rotation_matrix
from sim_nodes.physics import BodyState, ContactPoint
from sim_nodes.robots.declaration import BumperDeclaration
from sim_nodes.sensors.sensor import Values
from sim_nodes.stateful import Stateful
from sim_nodes.ticks import TICK

RELEASE_TICKS = round(0.1 / TICK)  # without contact before a zone is released, so that rattling presses it once


@dataclass(frozen=True)
class Bump:
    """A zone pressed by an entity since a tick."""

    zone: str
    entity: str
    since: int


@dataclass(frozen=True)
class Bumps:
    """All presses of a bumper, by zone and entity."""

    bumps: tuple[Bump, ...]


class Bumper(Stateful):
    """A `Sensor`: the bumper of a robot. Contacts of all physics steps are kept until the next sample.

    Args:
        declaration: Declaration of the bumper.
        state: Reads the state of the base.
    """

    STATE = ("_pressed",)

    period = 1
    quantities: tuple[Quantity, ...] = ()
    limits = (-math.inf, math.inf)
    bearings: Array = np.zeros(0)

    def __init__(self, declaration: BumperDeclaration, state: Callable[[], BodyState]) -> None:
        self._declaration = declaration
        self._state = state
        self._pressed: dict[tuple[str, str], tuple[int, int]] = {}  # first and last tick by zone and entity

    @property
    def zones(self) -> tuple[str, ...]:
        """Names of its zones."""
        return tuple(zone.name for zone in self._declaration.zones)

    def touch(self, points: Sequence[ContactPoint], tick: int) -> None:
        """Add the contact points of a physics step, before a tick."""
        state = self._state()
        to_base = rotation_matrix(state.orientation).T
        for point in points:
            zone = self._zone_of(*(to_base @ np.subtract(point.position, state.position)).tolist())
            if zone is not None:
                first, last = self._pressed.get((zone, point.entity), (tick, tick))
                is_over = tick - last > RELEASE_TICKS
                self._pressed[zone, point.entity] = (tick if is_over else first, tick)

    def _zone_of(self, x: float, y: float, z: float) -> str | None:
        """Return the zone of a point in the base's frame [m]."""
        if not self._declaration.lowest <= z <= self._declaration.highest:
            return None
        bearing = math.atan2(y, x)
        return next((zone.name for zone in self._declaration.zones if zone.start <= bearing <= zone.end), None)

    def read(self, tick: int) -> Bumps:
        """Return the presses since the last sample."""
        self._pressed = {
            key: (first, last) for key, (first, last) in self._pressed.items() if tick - last <= RELEASE_TICKS
        }
        pressed = sorted(self._pressed.items())
        return Bumps(tuple(Bump(zone, entity, first) for (zone, entity), (first, _) in pressed))

    def values(self, data: Bumps) -> Values:
        """Return nothing: the data have no numbers."""
        return {}

    def with_values(self, data: Bumps, values: Values) -> Bumps:
        """Return the data unchanged: they have no numbers."""
        return data
