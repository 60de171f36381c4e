"""Poses in the plane and in space.

Angles are in radians. Orientations in space are unit quaternions (w, x, y, z). Roll, pitch and yaw follow ISO
8855: rotation about z first, then about the new y, then about the new x.
"""

from __future__ import annotations

import math
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
Frame = tuple[Vector, Quaternion]
"""Position of an origin [m] and orientation, in a parent frame."""
Angle = TypeVar("Angle", float, Array)

LOCKED = 1e-12  # distance of the sine of a pitch from 1 at which roll and yaw have the same axis


def wrap(angle: Angle) -> Angle:
    """Normalize an angle, or an array of angles, to [-pi, pi)."""
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


def vector(values: Array) -> Vector:
    """Return an array of shape (3,) as a tuple."""
    x, y, z = values.tolist()
    return x, y, z


class Pose2(NamedTuple):
    """A pose in the plane, or the transform from its frame to the parent frame."""

    x: float  # [m]
    y: float  # [m]
    yaw: float  # [rad]

    def compose(self, inner: Pose2) -> Pose2:
        """Return the pose `inner`, given in this frame, in the parent of this frame."""
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        return Pose2(
            self.x + cos * inner.x - sin * inner.y,
            self.y + sin * inner.x + cos * inner.y,
            wrap(self.yaw + inner.yaw),
        )

    def inverse(self) -> Pose2:
        """Return the pose of the parent in this frame."""
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        return Pose2(-cos * self.x - sin * self.y, sin * self.x - cos * self.y, wrap(-self.yaw))

    def distance(self, x: float, y: float) -> float:
        """Return the distance of the origin of this pose to a point of the same frame [m]."""
        return math.hypot(self.x - x, self.y - y)


def quaternion(roll: float, pitch: float, yaw: float) -> Quaternion:
    """Return the orientation with these angles."""
    cr, sr = math.cos(roll / 2), math.sin(roll / 2)
    cp, sp = math.cos(pitch / 2), math.sin(pitch / 2)
    cy, sy = math.cos(yaw / 2), math.sin(yaw / 2)
    return (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )


def roll_pitch_yaw(orientation: Quaternion) -> Vector:
    """Return the angles of an orientation; pitch is in [-pi/2, pi/2], and at both ends yaw is 0."""
    w, x, y, z = orientation
    sine = 2 * (w * y - z * x)
    if abs(sine) > 1.0 - LOCKED:
        return wrap(2 * math.atan2(x, w)), math.copysign(math.pi / 2, sine), 0.0
    roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    return roll, math.asin(sine), yaw_of(orientation)


def yaw_of(orientation: Quaternion) -> float:
    """Return the yaw of an orientation."""
    w, x, y, z = orientation
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def multiply(first: Quaternion, second: Quaternion) -> Quaternion:
    """Return the orientation `second`, given in a frame of orientation `first`, in the parent of that frame."""
    a, b, c, d = first
    e, f, g, h = second
    return (
        a * e - b * f - c * g - d * h,
        a * f + b * e + c * h - d * g,
        a * g - b * h + c * e + d * f,
        a * h + b * g - c * f + d * e,
    )


def conjugate(orientation: Quaternion) -> Quaternion:
    """Return the inverse orientation: that of the parent in the rotated frame."""
    w, x, y, z = orientation
    return w, -x, -y, -z


def rotated(orientation: Quaternion, vector: Vector) -> Vector:
    """Rotate a vector from the rotated frame to its parent."""
    w, x, y, z = orientation
    a, b, c = vector
    # v + 2 w (q x v) + 2 q x (q x v), q the vector part
    i, j, k = 2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)
    return a + w * i + y * k - z * j, b + w * j + z * i - x * k, c + w * k + x * j - y * i


def rotation_matrix(orientation: Quaternion) -> Array:
    """Return the (3, 3) matrix that rotates vectors from the rotated frame to its parent."""
    w, x, y, z = orientation
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def quaternion_of(matrix: Array) -> Quaternion:
    """Return the orientation of a (3, 3) rotation matrix, by its largest component [Shepperd 1978]."""
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = matrix.tolist()
    # Each row is the quaternion times four of its components, in the order w, x, y, z.
    rows = (
        (1 + xx + yy + zz, zy - yz, xz - zx, yx - xy),
        (zy - yz, 1 + xx - yy - zz, xy + yx, xz + zx),
        (xz - zx, xy + yx, 1 - xx + yy - zz, yz + zy),
        (yx - xy, xz + zx, yz + zy, 1 - xx - yy + zz),
    )
    row = rows[max(range(4), key=lambda index: rows[index][index])]
    norm = math.hypot(*row)
    w, x, y, z = (value / norm for value in row)
    return (w, x, y, z)


def compose_frames(outer: Frame, inner: Frame) -> Frame:
    """Compose frames: `inner` is given in `outer`; returns it in the parent of `outer`."""
    return vector(rotation_matrix(outer[1]) @ inner[0] + outer[0]), multiply(outer[1], inner[1])


def inverse_frame(frame: Frame) -> Frame:
    """Return the parent frame in a frame."""
    turn = conjugate(frame[1])
    x, y, z = rotated(turn, frame[0])
    return (-x, -y, -z), turn


def lengths_along(points: Array) -> Array:
    """Return the length of a polyline from its start to each of its points [m].

    Args:
        points: Points of the plane, shape (n, 2) [m], n >= 1.

    Returns:
        The lengths, shape (n,).
    """
    return np.append(0.0, np.cumsum(np.hypot(*np.diff(points, axis=0).T)))
