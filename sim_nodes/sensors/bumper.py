"""A bumper: which of its zones are pressed, by what, and since when."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from seoro.bridges.wire import Quantity
from sim_nodes.geometry import Array, rotation_matrix
from sim_nodes.physics import BodyState, TouchPoint
from sim_nodes.robots.declaration import BumperDeclaration
from sim_nodes.sensors.sensor import Values
from sim_nodes.stateful import Stateful
from sim_nodes.ticks import TICK

RELEASE_TICKS = round(0.1 / TICK)  # without contact before a zone is released: things that rattle press once


@dataclass(frozen=True)
class Bump:
    """A zone that is pressed by an entity since a tick."""

    zone: str
    entity: str
    since: int


@dataclass(frozen=True)
class Bumps:
    """All that presses a bumper, by zone and entity."""

    bumps: tuple[Bump, ...]


class Bumper(Stateful):
    """The bumper of a robot; a `Sensor`. Contacts of any physics step are held until the next sample.

    Args:
        declaration: What is declared of it.
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
        self._pressed: dict[tuple[str, str], tuple[int, int]] = {}  # first and last tick, by zone and entity

    @property
    def zones(self) -> tuple[str, ...]:
        """Names of its zones."""
        return tuple(zone.name for zone in self._declaration.zones)

    def touch(self, points: Sequence[TouchPoint], tick: int) -> None:
        """Note what touches the robot in a physics step, before the tick with that number."""
        state = self._state()
        to_base = rotation_matrix(state.orientation).T
        for point in points:
            zone = self._zone_of(*(to_base @ np.subtract(point.position, state.position)).tolist())
            if zone is not None:
                first, last = self._pressed.get((zone, point.entity), (tick, tick))
                is_over = tick - last > RELEASE_TICKS
                self._pressed[zone, point.entity] = (tick if is_over else first, tick)

    def _zone_of(self, x: float, y: float, z: float) -> str | None:
        """The zone in which a point of the base's frame lies [m]."""
        if not self._declaration.lowest <= z <= self._declaration.highest:
            return None
        bearing = math.atan2(y, x)
        return next((zone.name for zone in self._declaration.zones if zone.start <= bearing <= zone.end), None)

    def read(self, tick: int) -> Bumps:
        """What presses it now, or has since the last sample."""
        self._pressed = {
            key: (first, last) for key, (first, last) in self._pressed.items() if tick - last <= RELEASE_TICKS
        }
        pressed = sorted(self._pressed.items())
        return Bumps(tuple(Bump(zone, entity, first) for (zone, entity), (first, _) in pressed))

    def values(self, data: Bumps) -> Values:
        """None: what it says is no numbers."""
        return {}

    def with_values(self, data: Bumps, values: Values) -> Bumps:
        """The same: there are no numbers in it."""
        return data
