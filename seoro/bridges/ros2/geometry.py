"""Poses, turns and times as seoro says them and as messages of ROS 2 have them.

Seoro has roll, pitch and yaw after ISO 8855 (yaw first), ROS quaternions; seoro seconds, ROS stamps.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from seoro.bridges.wire import Orientation, Pose, Twist, Vector3

NANO = 1_000_000_000


class Quaternion(NamedTuple):
    """A turn, of length one."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    w: float = 1.0

    def times(self, other: Quaternion) -> Quaternion:
        """The turn `other`, and then this one."""
        ax, ay, az, aw = self
        bx, by, bz, bw = other
        return Quaternion(
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
            aw * bw - ax * bx - ay * by - az * bz,
        )

    def turned(self, x: float, y: float, z: float) -> tuple[float, float, float]:
        """A vector after this turn."""
        turned = self.times(Quaternion(x, y, z, 0.0)).times(Quaternion(-self.x, -self.y, -self.z, self.w))
        return turned.x, turned.y, turned.z


def quaternion(roll: float, pitch: float, yaw: float) -> Quaternion:
    """The turn by angles [rad]: about z, then the new y, then the new x."""
    half = [(math.cos(angle / 2.0), math.sin(angle / 2.0)) for angle in (roll, pitch, yaw)]
    (cr, sr), (cp, sp), (cy, sy) = half
    return Quaternion(
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )


def orientation(message: Any) -> Orientation:
    """The angles of a `geometry_msgs/Quaternion`, which needs not have the length one.

    Raises:
        ValueError: It is no turn: all of it is zero, or a part of it is no number.
    """
    length = math.hypot(message.x, message.y, message.z, message.w)
    if not 0.0 < length < math.inf:
        raise ValueError("the orientation is no quaternion: its length is not above zero")
    x, y, z, w = (part / length for part in (message.x, message.y, message.z, message.w))
    return Orientation(
        roll=math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)),
        pitch=math.asin(max(-1.0, min(1.0, 2.0 * (w * y - z * x)))),
        yaw=math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)),
    )


def pose(message: Any) -> Pose:
    """What a `geometry_msgs/Pose` says.

    Raises:
        ValueError: Its orientation is no turn.
    """
    return Pose(position=vector(message.position), orientation=orientation(message.orientation))


def vector(message: Any) -> Vector3:
    """What a `geometry_msgs/Vector3` or `Point` says."""
    return Vector3(x=message.x, y=message.y, z=message.z)


def twist(message: Any) -> Twist:
    """What a `geometry_msgs/Twist` says."""
    return Twist(linear=vector(message.linear), angular=vector(message.angular))


def vector_message(value: Vector3) -> dict[str, float]:
    """A `geometry_msgs/Vector3` or `Point`."""
    return {"x": value.x, "y": value.y, "z": value.z}


def orientation_message(value: Orientation) -> dict[str, float]:
    """A `geometry_msgs/Quaternion`."""
    return quaternion(value.roll, value.pitch, value.yaw)._asdict()


def pose_message(value: Pose) -> dict[str, Any]:
    """A `geometry_msgs/Pose`."""
    return {"position": vector_message(value.position), "orientation": orientation_message(value.orientation)}


def transform_message(value: Pose) -> dict[str, Any]:
    """A `geometry_msgs/Transform`."""
    return {"translation": vector_message(value.position), "rotation": orientation_message(value.orientation)}


def twist_message(value: Twist) -> dict[str, Any]:
    """A `geometry_msgs/Twist`."""
    return {"linear": vector_message(value.linear), "angular": vector_message(value.angular)}


def stamp(time: float) -> dict[str, int]:
    """A `builtin_interfaces/Time` or `Duration` of a time [s]."""
    seconds, nanoseconds = divmod(round(time * NANO), NANO)
    return {"sec": seconds, "nanosec": nanoseconds}


def seconds(message: Any) -> float:
    """What a `builtin_interfaces/Time` or `Duration` says [s]."""
    return float(message.sec + message.nanosec / NANO)


def header(frame: str, time: float) -> Mapping[str, Any]:
    """A `std_msgs/Header` of a time [s]."""
    return {"stamp": stamp(time), "frame_id": frame}
