"""Wheel odometry: dead reckoning from the encoders, with accumulating errors."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from seoro.bridges.wire import Quantity
from sim_nodes.geometry import Array, Pose2, wrap
from sim_nodes.noise import Noise
from sim_nodes.robots.declaration import DriveDeclaration, OdometryDeclaration
from sim_nodes.robots.diff_drive import AT_REST, Velocity, base_motion
from sim_nodes.sensors.sensor import Values
from sim_nodes.stateful import Stateful
from sim_nodes.ticks import TICK

STILL = 1e-5  # [m], [rad]; less motion in a tick is rest, without errors

ReadWheels = Callable[[], tuple[float, float]]
"""Returns the angles that the left and right wheel have turned [rad]."""


@dataclass(frozen=True)
class Odometer:
    """Odometry data; the initial pose is the origin of the frame `odom`.

    Attributes:
        pose: Pose of the base in `odom`.
        travelled: Length of the path [m].
        velocity: Velocity of the base since the last reading, by the encoders, without accumulated errors.
    """

    pose: Pose2
    travelled: float
    velocity: Velocity


AT_START = Odometer(Pose2(0.0, 0.0, 0.0), 0.0, AT_REST)


class Odometry(Stateful):
    """A `Sensor`: the odometry of a differential drive.

    Args:
        drive: Declaration of the drive.
        declaration: Errors.
        noise: Source of random numbers.
        wheels: Reads the encoders of the wheels.
    """

    STATE = ("_angles", "_now", "_tick")

    period = 1
    quantities = (Quantity.LENGTH, Quantity.ANGLE)
    limits = (-math.inf, math.inf)
    bearings: Array = np.zeros(0)

    def __init__(
        self, drive: DriveDeclaration, declaration: OdometryDeclaration, noise: Noise, wheels: ReadWheels
    ) -> None:
        self._drive = drive
        self._declaration = declaration
        self._noise = noise
        self._wheels = wheels
        self._angles: tuple[float, float] | None = None
        self._now = AT_START
        self._tick: int | None = None  # of the last reading; idle robots are read less often

    def read(self, tick: int) -> Odometer:
        """Update with the motion of the wheels since the last reading."""
        angles = self._wheels()
        last, self._angles = self._angles or angles, angles
        distance, turn = base_motion(self._drive, angles[0] - last[0], angles[1] - last[1])
        ticks = 1 if self._tick is None else tick - self._tick
        self._tick = tick
        velocity = Velocity(distance / (ticks * TICK), turn / (ticks * TICK))
        if abs(distance) > ticks * STILL or abs(turn) > ticks * STILL:
            distance, turn = self._disturbed(distance, turn, tick)
        x, y, yaw = self._now.pose
        middle = yaw + turn / 2.0
        pose = Pose2(x + distance * math.cos(middle), y + distance * math.sin(middle), wrap(yaw + turn))
        self._now = Odometer(pose, self._now.travelled + abs(distance), velocity)
        return self._now

    def values(self, data: Odometer) -> Values:
        """Return position and heading."""
        return {Quantity.LENGTH: np.array(data.pose[:2]), Quantity.ANGLE: np.array(data.pose[2:])}

    def with_values(self, data: Odometer, values: Values) -> Odometer:
        """Return the data with another position and heading."""
        (x, y), (yaw,) = values[Quantity.LENGTH].tolist(), values[Quantity.ANGLE].tolist()
        return Odometer(Pose2(x, y, wrap(yaw)), data.travelled, data.velocity)

    def _disturbed(self, distance: float, turn: float, tick: int) -> tuple[float, float]:
        errors = self._declaration
        a, b, c = self._noise.at(tick).standard_normal(3).tolist()
        way = math.sqrt(abs(distance))
        return (
            distance + a * errors.distance_noise * way,
            turn + b * errors.turn_noise * math.sqrt(abs(turn)) + c * errors.drift_noise * way,
        )
