"""Velocities and states of entities."""

from __future__ import annotations

from seoro.bridges.wire.message import Message
from seoro.robotics.geometry import Pose3D


class Vector3(Message):
    """Three components along x, y, z."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0


class Twist(Message):
    """Linear [m/s] and angular [rad/s] velocity."""

    linear: Vector3 = Vector3()
    angular: Vector3 = Vector3()


class EntityState(Message):
    """Pose and motion of an entity."""

    pose: Pose3D = Pose3D()
    twist: Twist = Twist()
