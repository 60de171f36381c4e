"""Rigid transforms: a translation and a rotation, as quaternion.

Plain numbers instead of numpy: for a few of them, numpy takes ten times as long.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

Vector = tuple[float, float, float]  # x, y, z [m]
Quaternion = tuple[float, float, float, float]  # x, y, z, w; of length 1

_ALMOST_ONE = 1.0 - 1e-9  # cosine beyond which the arc of a rotation is as good as straight


@dataclass(frozen=True, slots=True)
class Transform:
    """Where a frame is in another one.

    Attributes:
        translation: Of its origin.
        rotation: Of its axes.
    """

    translation: Vector
    rotation: Quaternion

    def __matmul__(self, other: Transform) -> Transform:
        """Where a frame is in the outermost one: `odom_in_map @ base_in_odom` is `base_in_map`."""
        return Transform(self.apply(other.translation), _product(self.rotation, other.rotation))

    def inverse(self) -> Transform:
        """Where the other frame is in this one."""
        rotation = _conjugate(self.rotation)
        x, y, z = rotate(rotation, self.translation)
        return Transform((-x, -y, -z), rotation)

    def apply(self, point: Vector) -> Vector:
        """Where a point of the frame is in the other one."""
        x, y, z = rotate(self.rotation, point)
        own_x, own_y, own_z = self.translation
        return (own_x + x, own_y + y, own_z + z)

    def distance_to(self, other: Transform) -> float:
        """How far the origins are from each other [m]."""
        return math.dist(self.translation, other.translation)

    def angle_to(self, other: Transform) -> float:
        """By which angle, from 0 to pi [rad], the axes are turned to each other."""
        x, y, z, w = _product(_conjugate(self.rotation), other.rotation)
        return 2 * math.atan2(math.hypot(x, y, z), abs(w))

    @property
    def yaw(self) -> float:
        """The angle about the z axis [rad]."""
        x, y, z, w = self.rotation
        return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


IDENTITY = Transform((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))


def interpolate(before: Transform, after: Transform, share: float) -> Transform:
    """What lies between two transforms: on the straight line, and on the shortest arc (slerp).

    Args:
        before: At a share of 0.
        after: At a share of 1.
        share: From 0 to 1.
    """
    (ax, ay, az), (bx, by, bz) = before.translation, after.translation
    translation = (ax + share * (bx - ax), ay + share * (by - ay), az + share * (bz - az))
    return Transform(translation, _slerp(before.rotation, after.rotation, share))


def rotate(rotation: Quaternion, vector: Vector) -> Vector:
    """A vector, turned."""
    x, y, z, w = rotation
    vx, vy, vz = vector
    # v + 2 q x (q x v + w v), with the vector part q
    cx, cy, cz = y * vz - z * vy + w * vx, z * vx - x * vz + w * vy, x * vy - y * vx + w * vz
    return (vx + 2 * (y * cz - z * cy), vy + 2 * (z * cx - x * cz), vz + 2 * (x * cy - y * cx))


def normalised(rotation: Quaternion) -> Quaternion | None:
    """A quaternion of length 1; None if it has no direction, or is no number."""
    length = math.hypot(*rotation)
    if not 1e-6 < length < math.inf:
        return None
    x, y, z, w = rotation
    return (x / length, y / length, z / length, w / length)


def _product(a: Quaternion, b: Quaternion) -> Quaternion:
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def _conjugate(rotation: Quaternion) -> Quaternion:
    x, y, z, w = rotation
    return (-x, -y, -z, w)


def _slerp(a: Quaternion, b: Quaternion, share: float) -> Quaternion:
    cosine = sum(p * q for p, q in zip(a, b, strict=True))
    sign = 1.0 if cosine >= 0 else -1.0  # q and -q are the same rotation; the shorter way is meant
    cosine = abs(cosine)
    if cosine > _ALMOST_ONE:
        first, second = 1 - share, share * sign
    else:
        angle = math.acos(cosine)
        sine = math.sin(angle)
        first, second = math.sin((1 - share) * angle) / sine, sign * math.sin(share * angle) / sine
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    mixed = (
        first * ax + second * bx,
        first * ay + second * by,
        first * az + second * bz,
        first * aw + second * bw,
    )
    found = normalised(mixed)
    assert found is not None, "what is mixed lies on the shorter arc"
    return found
