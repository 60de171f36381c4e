"""Poses and twists."""

from __future__ import annotations

from seoro.bridges.wire.message import Message


class Vector3(Message):
    """Three components along x, y, z."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0


class Orientation(Message):
    """Roll, pitch, yaw [rad]."""

    roll: float = 0.0
    pitch: float = 0.0
    yaw: float = 0.0


class Pose(Message):
    """Position [m] and orientation [rad]."""

    position: Vector3 = Vector3()
    orientation: Orientation = Orientation()


class Twist(Message):
    """Linear [m/s] and angular [rad/s] velocity."""

    linear: Vector3 = Vector3()
    angular: Vector3 = Vector3()


class EntityState(Message):
    """Where an entity is and how it moves."""

    pose: Pose = Pose()
    twist: Twist = Twist()
