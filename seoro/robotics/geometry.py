"""Positions, poses and velocities. Units are SI, angles radians."""

from __future__ import annotations

import math
from typing import ClassVar, NamedTuple

from seoro.deferred import dataclass


@dataclass(frozen=True)
class Record:
    """A frozen dataclass; messages check its fields and convert integers to floats."""

    __pydantic_config__: ClassVar = {"revalidate_instances": "always"}


@dataclass(frozen=True)
class Position3D(Record):
    """Position [m]."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0


@dataclass(frozen=True)
class Orientation3D(Record):
    """Roll, pitch, yaw [rad], yaw first (ISO 8855)."""

    roll: float = 0.0
    pitch: float = 0.0
    yaw: float = 0.0


@dataclass(frozen=True)
class Pose3D(Record):
    """Position and orientation."""

    position: Position3D = Position3D()
    orientation: Orientation3D = Orientation3D()


@dataclass(frozen=True)
class TranslationalVelocity3D(Record):
    """Velocity [m/s]."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0


@dataclass(frozen=True)
class OrientationRate3D(Record):
    """Rates of roll, pitch, yaw [rad/s]."""

    roll: float = 0.0
    pitch: float = 0.0
    yaw: float = 0.0


@dataclass(frozen=True)
class Velocity6D(Record):
    """Translational and angular velocity."""

    translational: TranslationalVelocity3D = TranslationalVelocity3D()
    angular: OrientationRate3D = OrientationRate3D()


class Quaternion(NamedTuple):
    """Rotation as a quaternion of length one."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    w: float = 1.0


def quaternion(roll: float, pitch: float, yaw: float) -> Quaternion:
    """Return the rotation by angles [rad]: about z, then the new y, then the new x."""
    half = [(math.cos(angle / 2.0), math.sin(angle / 2.0)) for angle in (roll, pitch, yaw)]
    (cr, sr), (cp, sp), (cy, sy) = half
    return Quaternion(
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )
