"""Measures of robots and other entities, and limits of them."""

from __future__ import annotations

from enum import StrEnum
from types import MappingProxyType
from typing import Final

from seoro.deferred import dataclass

FAR: Final = 1e6  # [m] edge of an area that is not bounded


class Measure(StrEnum):
    """Names of measures."""

    CLEARANCE = "clearance"  # distance of a robot's outline to the nearest entity, or to `other`, from above
    SPEED = "speed"  # true speed in the plane; 0 outside of `area`
    LOCALIZATION_ERROR = "localization_error"  # between the estimated and the true position; 0 without an estimate
    PATH_LENGTH = "path_length"  # of the true path since the watch began
    AREA_DISTANCE = "area_distance"  # of the entity's origin to `area`; 0 within
    TIME_IN_AREA = "time_in_area"  # since the watch began
    TILT = "tilt"  # between the z axis of the entity's frame and the vertical
    WORK = "work"  # mechanical work of a robot's motors since the watch began


UNITS: Final = MappingProxyType(
    {
        Measure.CLEARANCE: "m",
        Measure.SPEED: "m/s",
        Measure.LOCALIZATION_ERROR: "m",
        Measure.PATH_LENGTH: "m",
        Measure.AREA_DISTANCE: "m",
        Measure.TIME_IN_AREA: "s",
        Measure.TILT: "rad",
        Measure.WORK: "J",
    }
)
"""Units of measures."""
ONLY_DRIVING: Final = frozenset({Measure.CLEARANCE, Measure.LOCALIZATION_ERROR})
"""Measures of robots that drive only."""
ONLY_ROBOTS: Final = ONLY_DRIVING | {Measure.WORK}
"""Measures of robots only."""


@dataclass(frozen=True)
class Area:
    """A rectangle in the map, parallel to its axes [m]."""

    x_min: float = -FAR
    y_min: float = -FAR
    x_max: float = FAR
    y_max: float = FAR


@dataclass(frozen=True)
class MeasureLimit:
    """A limit of a measure.

    Args:
        measure: The measure.
        value: The limit, in the unit of the measure.
        above: Whether it is reached above the value; otherwise at it or below.
        other: The other entity of a clearance; empty for the nearest.
        area: Area of measures that have one.
    """

    measure: Measure
    value: float
    above: bool
    other: str = ""
    area: Area = Area()
