"""Kinematics of a differential drive."""

from __future__ import annotations

from typing import NamedTuple

from sim_nodes.robots.declaration import DriveDeclaration


class Velocity(NamedTuple):
    """Velocity of a base: ahead [m/s] and turning left [rad/s]."""

    linear: float
    angular: float


AT_REST = Velocity(0.0, 0.0)


def wheel_ways(drive: DriveDeclaration, velocity: Velocity) -> tuple[float, float]:
    """Speeds of the base at the left and right wheel [m/s]."""
    half = velocity.angular * drive.wheel_separation / 2.0
    return velocity.linear - half, velocity.linear + half


def wheel_speeds(drive: DriveDeclaration, velocity: Velocity) -> tuple[float, float]:
    """Speeds of the left and right wheel [rad/s] at which the base moves with a velocity."""
    left, right = wheel_ways(drive, velocity)
    return left / drive.wheel_radius, right / drive.wheel_radius


def base_motion(drive: DriveDeclaration, left: float, right: float) -> tuple[float, float]:
    """Distance [m] and change of heading [rad] of a base whose wheels turned by these angles [rad]."""
    left_way, right_way = left * drive.wheel_radius, right * drive.wheel_radius
    return (left_way + right_way) / 2.0, (right_way - left_way) / drive.wheel_separation
