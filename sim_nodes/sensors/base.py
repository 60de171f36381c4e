"""Sensors of a wheeled base besides the lidar: wheel odometry, inertial measurement unit, and bumper."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from operator import sub
from typing import NamedTuple

import numpy as np

from seoro.bridges.wire import Quantity
from seoro.deferred import dataclass
from sim_nodes.geometry import Array, Pose2, Vector, rotation_matrix, wrap
from sim_nodes.noise import Noise
from sim_nodes.physics import BodyState, ContactPoint
from sim_nodes.robots.declaration import BumperDeclaration, ImuDeclaration, OdometryDeclaration
from sim_nodes.robots.drive_declaration import DriveDeclaration
from sim_nodes.robots.kinematics import AT_REST, Velocity, base_motion, wheel_joints
from sim_nodes.sensors.sensor_pipeline import Sensor, Values, period_of
from sim_nodes.ticks import TICK

STILL = 1e-5  # [m], [rad]; less motion in a tick is rest, without errors

ReadWheels = Callable[[], tuple[float, ...]]
"""Returns the angles that the motors have turned [rad], in the order of `robots/kinematics.py`."""


class Odometer(NamedTuple):
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


class Odometry(Sensor[Odometer]):
    """The odometry of a drive.

    Args:
        drive: Declaration of the drive.
        declaration: Errors.
        noise: Source of random numbers.
        wheels: Reads the encoders of the wheels.
    """

    STATE = ("_angles", "_now", "_tick")

    quantities = (Quantity.LENGTH, Quantity.ANGLE)

    def __init__(
        self, drive: DriveDeclaration, declaration: OdometryDeclaration, noise: Noise, wheels: ReadWheels
    ) -> None:
        self._drive = drive
        self._declaration = declaration
        self._noise = noise
        self._wheels = wheels
        self._count = len(wheel_joints(drive))
        self._angles: tuple[float, ...] | None = None
        self._now = AT_START
        self._tick: int | None = None  # of the last reading; idle robots are read less often

    def read(self, tick: int) -> Odometer:
        """Update with the motion of the wheels since the last reading."""
        angles = self._wheels()
        last, self._angles = self._angles or angles, angles
        turned = map(sub, angles[: self._count], last)
        moved = base_motion(self._drive, (*turned, *angles[self._count :]))
        distance, turn, sideways = moved
        ticks = 1 if self._tick is None else tick - self._tick
        self._tick = tick
        interval, still = ticks * TICK, ticks * STILL
        velocity = Velocity(distance / interval, turn / interval, sideways / interval)
        if abs(distance) > still or abs(turn) > still or abs(sideways) > still:
            distance, turn, sideways = self._disturbed(moved, tick)
        x, y, yaw = self._now.pose
        middle = yaw + turn / 2.0
        ahead, left = math.cos(middle), math.sin(middle)
        x, y, way = x + distance * ahead, y + distance * left, abs(distance)
        if sideways:
            x, y, way = x - sideways * left, y + sideways * ahead, math.hypot(distance, sideways)
        self._now = Odometer(Pose2(x, y, wrap(yaw + turn)), self._now.travelled + way, velocity)
        return self._now

    def values(self, data: Odometer) -> Values:
        """Return position and heading."""
        return {Quantity.LENGTH: np.array(data.pose[:2]), Quantity.ANGLE: np.array(data.pose[2:])}

    def with_values(self, data: Odometer, values: Values) -> Odometer:
        """Return the data with another position and heading."""
        (x, y), (yaw,) = values[Quantity.LENGTH].tolist(), values[Quantity.ANGLE].tolist()
        return Odometer(Pose2(x, y, wrap(yaw)), data.travelled, data.velocity)

    def _disturbed(self, moved: Velocity, tick: int) -> Velocity:
        errors = self._declaration
        a, b, c, d = self._noise.at(tick).standard_normal(4).tolist()
        distance, turn, sideways = moved
        way = math.sqrt(math.hypot(distance, sideways) if sideways else abs(distance))
        return Velocity(
            distance + a * errors.distance_noise * way,
            turn + b * errors.turn_noise * math.sqrt(abs(turn)) + c * errors.drift_noise * way,
            sideways + d * errors.distance_noise * way if self._drive.max_lateral_speed else 0.0,
        )


FREE_FALL = np.array([0.0, 0.0, -9.81])  # [m/s^2]


@dataclass(frozen=True)
class Inertial:
    """Data of an IMU, in the frame of the base.

    Attributes:
        acceleration: Proper acceleration: upwards at rest, by gravity [m/s^2], shape (3,).
        angular_rate: Angular velocity [rad/s], shape (3,).
    """

    acceleration: Array
    angular_rate: Array


class Imu(Sensor[Inertial]):
    """The IMU of a robot. The acceleration is the mean since the last sample.

    Args:
        declaration: Declaration of the IMU.
        noise: Source of random numbers.
        bias: Source of the constant biases.
        state: Reads the state of the base.
    """

    STATE = ("_last",)

    quantities = (Quantity.ACCELERATION, Quantity.ANGULAR_RATE)

    def __init__(
        self, declaration: ImuDeclaration, noise: Noise, bias: Noise, state: Callable[[], BodyState]
    ) -> None:
        self._declaration = declaration
        self._noise = noise
        self._state = state
        draws = bias.at(0).standard_normal((2, 3))
        self._biases = (declaration.accelerometer_bias * draws[0], declaration.gyroscope_bias * draws[1])
        self._last: tuple[int, Vector] | None = None  # tick and velocity [m/s] of the last sample
        self.period = period_of(declaration.rate)

    def read(self, tick: int) -> Inertial:
        """Return a sample with the noise of a tick."""
        declaration, state = self._declaration, self._state()
        to_base = rotation_matrix(state.orientation).T
        acceleration = to_base @ (self._change(tick, state.linear) - FREE_FALL)
        errors = self._noise.at(tick).standard_normal((2, 3))
        return Inertial(
            acceleration + self._biases[0] + declaration.accelerometer_noise * errors[0],
            to_base @ state.angular + self._biases[1] + declaration.gyroscope_noise * errors[1],
        )

    def _change(self, tick: int, velocity: Vector) -> Array:
        """Return the mean acceleration since the last sample; zero if that is long ago [m/s^2]."""
        last, self._last = self._last, (tick, velocity)
        if last is None or tick - last[0] > self.period:
            return np.zeros(3)
        change: Array = np.subtract(velocity, last[1]) / ((tick - last[0]) * TICK)
        return change

    def values(self, data: Inertial) -> Values:
        """Return both vectors."""
        return {Quantity.ACCELERATION: data.acceleration, Quantity.ANGULAR_RATE: data.angular_rate}

    def with_values(self, data: Inertial, values: Values) -> Inertial:
        """Return data with other vectors."""
        return Inertial(values[Quantity.ACCELERATION], values[Quantity.ANGULAR_RATE])


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


UNTOUCHED = Bumps(())


class Bumper(Sensor[Bumps]):
    """The bumper of a robot. Contacts of all physics steps are kept until the next sample.

    Args:
        declaration: Declaration of the bumper.
        state: Reads the state of the base.
    """

    STATE = ("_pressed",)

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
        if not self._pressed:
            return UNTOUCHED
        self._pressed = {
            key: (first, last) for key, (first, last) in self._pressed.items() if tick - last <= RELEASE_TICKS
        }
        pressed = sorted(self._pressed.items())
        return Bumps(tuple(Bump(zone, entity, first) for (zone, entity), (first, _) in pressed))
