"""Rigid transforms: a translation, and a rotation as a quaternion.

They use plain numbers: for so few of them, numpy takes ten times as long.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

Vector = tuple[float, float, float]  # x, y, z [m]
Quaternion = tuple[float, float, float, float]  # x, y, z, w; of length 1

_ALMOST_ONE = 1.0 - 1e-9  # cosine of an angle below which slerp is linear


@dataclass(frozen=True, slots=True)
class Transform:
    """Transform of a frame in another one.

    Attributes:
        translation: Position of its origin.
        rotation: Rotation of its axes.
    """

    translation: Vector
    rotation: Quaternion

    def __matmul__(self, other: Transform) -> Transform:
        """Compose transforms: `odom_in_map @ base_in_odom` is `base_in_map`."""
        return Transform(self.apply(other.translation), _product(self.rotation, other.rotation))

    def inverse(self) -> Transform:
        """Return the inverse transform."""
        rotation = _conjugate(self.rotation)
        x, y, z = rotate(rotation, self.translation)
        return Transform((-x, -y, -z), rotation)

    def apply(self, point: Vector) -> Vector:
        """Transform a point of the frame into the other frame."""
        x, y, z = rotate(self.rotation, point)
        own_x, own_y, own_z = self.translation
        return (own_x + x, own_y + y, own_z + z)


IDENTITY = Transform((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))


def interpolate(before: Transform, after: Transform, share: float) -> Transform:
    """Interpolate between two transforms: linearly, and along the shortest arc (slerp).

    Args:
        before: Transform at a share of 0.
        after: Transform at a share of 1.
        share: Number from 0 to 1.
    """
    (ax, ay, az), (bx, by, bz) = before.translation, after.translation
    translation = (ax + share * (bx - ax), ay + share * (by - ay), az + share * (bz - az))
    return Transform(translation, _slerp(before.rotation, after.rotation, share))


def rotate(rotation: Quaternion, vector: Vector) -> Vector:
    """Rotate a vector."""
    x, y, z, w = rotation
    vx, vy, vz = vector
    # v + 2 q x (q x v + w v), with the vector part q
    cx, cy, cz = y * vz - z * vy + w * vx, z * vx - x * vz + w * vy, x * vy - y * vx + w * vz
    return (vx + 2 * (y * cz - z * cy), vy + 2 * (z * cx - x * cz), vz + 2 * (x * cy - y * cx))


def normalised(rotation: Quaternion) -> Quaternion | None:
    """Return a quaternion of length 1; None if its length is zero or not finite."""
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
    sign = 1.0 if cosine >= 0 else -1.0  # q and -q are the same rotation; this selects the shorter arc
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
    assert found is not None, "the mean of two rotations on the shorter arc is not zero"
    return found
