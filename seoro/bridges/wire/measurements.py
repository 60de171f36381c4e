"""What a simulator has measured of a run so far."""

from __future__ import annotations

from collections.abc import Mapping

from seoro.bridges.wire.message import Empty, Message, Verb


class RobotMeasurements(Message):
    """Measurements of a robot that drives, since the world was loaded or reset.

    Errors of the localisation are distances between where it believes the robot to be and where that is, in every
    tick of 20 ms in which it has a pose; those of `_driving` while the robot moves.
    """

    path_length: float  # [m] that it really drove
    driving_time: float  # [s] in which it moved
    localisation_error: float | None  # mean [m]
    localisation_error_driving: float | None  # mean [m]
    localisation_error_max: float | None  # [m]
    localisation_deviation: float | None  # mean of the standard deviation that the localisation itself states [m]
    closest_approach: float | None  # of its outline to anything, seen from above [m]; None if there is nothing
    contacts: int
    goals_reached: int
    goals_aborted: int
    goals_canceled: int
    recoveries: int


class Measurements(Message):
    """What was measured of a run up to a time [s], by robot that drives."""

    world: str
    engine: str
    engine_version: str
    seed: int
    time: float
    robots: Mapping[str, RobotMeasurements]


GET_MEASUREMENTS = Verb("get_measurements", Empty, Measurements)
