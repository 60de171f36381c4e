"""Kinematics of drives: motors by velocities of the base, and motions of the base by motors.

Motors are the wheels, in the order of the declaration, followed by the steering joints. Their values are
angular speeds [rad/s], or angles for motions; those of steering joints are always angles [rad].

A wheel with rollers rolls freely along them, so the speed of its contact along their axis is that of its rim
(K. M. Lynch and F. C. Park: Modern Robotics, 2017, section 13.2). The Ackermann drive is that of a bicycle, whose
origin is on the rear axle (section 13.3.1.3).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from sim_nodes.geometry import Array
from sim_nodes.robots.drive_declaration import (
    DifferentialDrive,
    DriveDeclaration,
    DriveKind,
    PlanarDrive,
    WheelDeclaration,
)


class Velocity(NamedTuple):
    """Velocity of a base: forwards [m/s], turning left [rad/s], and sideways to the left [m/s].

    As a motion: distances [m] and a change of heading [rad].
    """

    linear: float
    angular: float
    lateral: float = 0.0


AT_REST = Velocity(0.0, 0.0)


def motor_joints(drive: DriveDeclaration) -> tuple[str, ...]:
    """Return the joints of the motors."""
    return (*wheel_joints(drive), *steering_joints(drive))


def wheel_joints(drive: DriveDeclaration) -> tuple[str, ...]:
    """Return the joints of the wheels."""
    if isinstance(drive, DifferentialDrive):
        return drive.left_joint, drive.right_joint
    return tuple(wheel.joint for wheel in drive.wheels)


def steering_joints(drive: DriveDeclaration) -> tuple[str, ...]:
    """Return the joints that steer."""
    if isinstance(drive, DifferentialDrive):
        return ()
    return tuple(wheel.steering for wheel in drive.steered if wheel.steering is not None)


def side_speeds(drive: DriveDeclaration, velocity: Velocity) -> tuple[float, float]:
    """Return the forward ground speed at the left and right wheels [m/s]."""
    half = velocity.angular * _separation(drive) / 2.0
    return velocity.linear - half, velocity.linear + half


def per_motor(drive: DriveDeclaration, left: float, right: float, steering: float) -> tuple[float, ...]:
    """Return values of motors: those of wheels by their side, and that of steering joints."""
    if isinstance(drive, DifferentialDrive):
        return left, right
    return (*(left if wheel.y > 0.0 else right for wheel in drive.wheels), *(steering for _ in drive.steered))


def motor_commands(drive: DriveDeclaration, velocity: Velocity) -> tuple[float, ...]:
    """Return the values of the motors for a velocity of the base.

    A velocity that the drive cannot have is that without the impossible component.
    """
    if isinstance(drive, DifferentialDrive):
        left, right = side_speeds(drive, velocity)
        return left / drive.wheel_radius, right / drive.wheel_radius
    if drive.kind is DriveKind.ACKERMANN:
        return _ackermann_commands(drive, velocity)
    linear, angular, lateral = velocity
    speeds = _wheel_matrix(drive) @ (linear, lateral, angular)
    return tuple(speeds.tolist())


def base_motion(drive: DriveDeclaration, motors: Sequence[float]) -> Velocity:
    """Return the velocity of the base by the speeds of motors, or its motion by the angles that they turned."""
    if isinstance(drive, DifferentialDrive):
        left, right = motors
        left_way, right_way = left * drive.wheel_radius, right * drive.wheel_radius
        return Velocity((left_way + right_way) / 2.0, (right_way - left_way) / drive.wheel_separation)
    if drive.kind is DriveKind.ACKERMANN:
        return _ackermann_motion(drive, motors)
    linear, lateral, angular = (_base_matrix(drive) @ motors).tolist()
    return Velocity(linear, angular, lateral)


def _separation(drive: DriveDeclaration) -> float:
    """Return the distance of the left from the right wheels [m]; the mean for several."""
    if isinstance(drive, DifferentialDrive):
        return drive.wheel_separation
    return 2.0 * sum(abs(wheel.y) for wheel in drive.wheels) / len(drive.wheels)


@lru_cache(maxsize=64)
def _wheel_matrix(drive: PlanarDrive) -> Array:
    """Return the matrix from the velocity (forwards, left, turning) to wheel speeds, shape (n, 3)."""
    return np.array([_wheel_row(wheel) for wheel in drive.wheels])


def _wheel_row(wheel: WheelDeclaration) -> tuple[float, float, float]:
    along = wheel.heading + wheel.roller  # axis of the rollers
    scale = 1.0 / (wheel.radius * math.cos(wheel.roller))
    x, y = math.cos(along) * scale, math.sin(along) * scale
    return x, y, wheel.x * y - wheel.y * x


@lru_cache(maxsize=64)
def _base_matrix(drive: PlanarDrive) -> Array:
    """Return the matrix from wheel speeds to the velocity of the base; skid steering has no lateral velocity."""
    matrix = _wheel_matrix(drive).copy()
    if drive.kind is DriveKind.SKID_STEER:
        matrix[:, 1] = 0.0
    return np.array(np.linalg.pinv(matrix))


# ------------------------------------------------------------ Ackermann


def _ackermann_commands(drive: PlanarDrive, velocity: Velocity) -> tuple[float, ...]:
    linear, angular, _ = velocity
    curvature = angular / linear if linear else 0.0
    speeds = (
        linear * math.hypot(1.0 - curvature * wheel.y, curvature * _lever(wheel)) / wheel.radius
        for wheel in drive.wheels
    )
    return (*speeds, *(math.atan2(curvature * wheel.x, 1.0 - curvature * wheel.y) for wheel in drive.steered))


def _lever(wheel: WheelDeclaration) -> float:
    """Return the distance of a steered wheel ahead of the rear axle [m]; others do not turn to their motion."""
    return wheel.x if wheel.steering is not None else 0.0


def _ackermann_motion(drive: PlanarDrive, motors: Sequence[float]) -> Velocity:
    turned, steering = motors[: len(drive.wheels)], motors[len(drive.wheels) :]
    # The curvature by each steered wheel: tan(angle) = curvature x / (1 - curvature y).
    curvature = sum(
        math.sin(angle) / (wheel.x * math.cos(angle) + wheel.y * math.sin(angle))
        for wheel, angle in zip(drive.steered, steering, strict=True)
    ) / len(drive.steered)
    linear = sum(
        angle * wheel.radius / math.hypot(1.0 - curvature * wheel.y, curvature * _lever(wheel))
        for wheel, angle in zip(drive.wheels, turned, strict=True)
    ) / len(drive.wheels)
    return Velocity(linear, linear * curvature)
