"""Measures of robots and other entities, and limits of them.

`MEASURES` is the one table of measures that limits can name: monitors, conditions and nodes derive from it.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from types import MappingProxyType
from typing import Final

FAR: Final = 1e6  # [m] edge of an area that is not bounded


class Measure(StrEnum):
    """Names of measures."""

    CLEARANCE = "clearance"
    SPEED = "speed"
    LOCALIZATION_ERROR = "localization_error"
    PATH_LENGTH = "path_length"
    AREA_DISTANCE = "area_distance"
    TIME_IN_AREA = "time_in_area"


@dataclass(frozen=True)
class MeasureInfo:
    """Unit and meaning of a measure; some are of robots that drive only."""

    unit: str
    meaning: str
    only_driving: bool = False


MEASURES: Final = MappingProxyType(
    {
        Measure.CLEARANCE: MeasureInfo(
            "m", "distance of the robot's circle to the nearest entity, or to `other`, from above", True
        ),
        Measure.SPEED: MeasureInfo("m/s", "true speed in the plane; 0 outside of `area`"),
        Measure.LOCALIZATION_ERROR: MeasureInfo(
            "m", "distance between the estimated and the true position; 0 without an estimate", True
        ),
        Measure.PATH_LENGTH: MeasureInfo("m", "length of the true path since the watch began"),
        Measure.AREA_DISTANCE: MeasureInfo("m", "distance of the entity's origin to `area`; 0 within"),
        Measure.TIME_IN_AREA: MeasureInfo("s", "time within `area` since the watch began"),
    }
)


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
