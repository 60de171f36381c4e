"""Conversion of poses, rotations and times between seoro and ROS 2 messages.

seoro uses roll, pitch and yaw after ISO 8855 (yaw first), and seconds; ROS 2 uses quaternions and time stamps.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from seoro.bridges.wire import Orientation3D, Pose3D, Position3D, Twist, Vector3
from seoro.robotics.geometry import quaternion

NANO = 1_000_000_000


def orientation(message: Any) -> Orientation3D:
    """Convert a `geometry_msgs/Quaternion` of any length.

    Raises:
        ValueError: The quaternion is zero or not finite.
    """
    length = math.hypot(message.x, message.y, message.z, message.w)
    if not 0.0 < length < math.inf:
        raise ValueError("invalid orientation: the norm of the quaternion is zero or not finite")
    x, y, z, w = (part / length for part in (message.x, message.y, message.z, message.w))
    return Orientation3D(
        roll=math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)),
        pitch=math.asin(max(-1.0, min(1.0, 2.0 * (w * y - z * x)))),
        yaw=math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)),
    )


def pose(message: Any) -> Pose3D:
    """Convert a `geometry_msgs/Pose`.

    Raises:
        ValueError: The orientation is invalid.
    """
    position = message.position
    return Pose3D(Position3D(position.x, position.y, position.z), orientation(message.orientation))


def vector(message: Any) -> Vector3:
    """Convert a `geometry_msgs/Vector3`."""
    return Vector3(x=message.x, y=message.y, z=message.z)


def twist(message: Any) -> Twist:
    """Convert a `geometry_msgs/Twist`."""
    return Twist(linear=vector(message.linear), angular=vector(message.angular))


def vector_message(value: Vector3 | Position3D) -> dict[str, float]:
    """Make a `geometry_msgs/Vector3` or `Point`."""
    return {"x": value.x, "y": value.y, "z": value.z}


def orientation_message(value: Orientation3D) -> dict[str, float]:
    """Make a `geometry_msgs/Quaternion`."""
    return quaternion(value.roll, value.pitch, value.yaw)._asdict()


def pose_message(value: Pose3D) -> dict[str, Any]:
    """Make a `geometry_msgs/Pose`."""
    return {"position": vector_message(value.position), "orientation": orientation_message(value.orientation)}


def transform_message(value: Pose3D) -> dict[str, Any]:
    """Make a `geometry_msgs/Transform`."""
    return {"translation": vector_message(value.position), "rotation": orientation_message(value.orientation)}


def twist_message(value: Twist) -> dict[str, Any]:
    """Make a `geometry_msgs/Twist`."""
    return {"linear": vector_message(value.linear), "angular": vector_message(value.angular)}


def stamp(time: float) -> dict[str, int]:
    """Make a `builtin_interfaces/Time` or `Duration` from seconds."""
    seconds, nanoseconds = divmod(round(time * NANO), NANO)
    return {"sec": seconds, "nanosec": nanoseconds}


def seconds(message: Any) -> float:
    """Convert a `builtin_interfaces/Time` or `Duration` to seconds."""
    return float(message.sec + message.nanosec / NANO)


def header(frame: str, time: float) -> Mapping[str, Any]:
    """Make a `std_msgs/Header` with a time [s]."""
    return {"stamp": stamp(time), "frame_id": frame}
