"""Kinematics of a differential drive."""

from __future__ import annotations

from typing import NamedTuple

from sim_nodes.robots.declaration import DriveDeclaration


class Velocity(NamedTuple):
    """Velocity of a base: forwards [m/s] and turning left [rad/s]."""

    linear: float
    angular: float


AT_REST = Velocity(0.0, 0.0)


def wheel_speeds(drive: DriveDeclaration, velocity: Velocity) -> tuple[float, float]:
    """Return the ground speed at the left and right wheel [m/s]."""
    half = velocity.angular * drive.wheel_separation / 2.0
    return velocity.linear - half, velocity.linear + half


def wheel_angular_speeds(drive: DriveDeclaration, velocity: Velocity) -> tuple[float, float]:
    """Return the angular speed of the left and right wheel [rad/s] for a velocity of the base."""
    left, right = wheel_speeds(drive, velocity)
    return left / drive.wheel_radius, right / drive.wheel_radius


def base_motion(drive: DriveDeclaration, left: float, right: float) -> tuple[float, float]:
    """Return the distance [m] and change of heading [rad] of a base whose wheels turned by these angles [rad]."""
    left_way, right_way = left * drive.wheel_radius, right * drive.wheel_radius
    return (left_way + right_way) / 2.0, (right_way - left_way) / drive.wheel_separation
