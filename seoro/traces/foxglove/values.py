"""Values of Foxglove's messages from values of a trace."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from foxglove.messages import Color, Pose, Quaternion, Timestamp, Vector3

SECOND: Final = 1_000_000_000  # [ns]
GREY: Final = "#808080"


def to_pose(values: Sequence[float]) -> Pose:
    """Convert x, y, z and a quaternion x, y, z, w; further values are ignored."""
    x, y, z, *rotation = values[:7]
    return Pose(position=Vector3(x=x, y=y, z=z), orientation=to_quaternion(rotation))


def to_quaternion(values: Sequence[float]) -> Quaternion:
    """Convert a quaternion x, y, z, w."""
    x, y, z, w = values
    return Quaternion(x=x, y=y, z=z, w=w)


def relative_pose(frame: Sequence[float], pose: Sequence[float]) -> list[float]:
    """Return a pose in a frame; both are x, y, z and a quaternion x, y, z, w in the same parent frame."""
    x, y, z, w = (-frame[3], -frame[4], -frame[5], frame[6])
    back = (x, y, z, w)
    moved = [pose[axis] - frame[axis] for axis in range(3)]
    turned = _product(_product(back, (*moved, 0.0)), (-x, -y, -z, w))
    return [*turned[:3], *_product(back, pose[3:7])]


def _product(first: Sequence[float], second: Sequence[float]) -> tuple[float, float, float, float]:
    """Return the product of two quaternions x, y, z, w."""
    a, b, c, d = first
    e, f, g, h = second
    return (
        d * e + a * h + b * g - c * f,
        d * f - a * g + b * h + c * e,
        d * g + a * f - b * e + c * h,
        d * h - a * e - b * f - c * g,
    )


def to_color(text: str) -> Color:
    """Convert a colour `#rrggbb`."""
    red, green, blue = (int(text[at : at + 2], 16) / 255.0 for at in (1, 3, 5))
    return Color(r=red, g=green, b=blue, a=1.0)


def to_timestamp(nanoseconds: int) -> Timestamp:
    """Convert a time since the epoch [ns]."""
    return Timestamp(sec=nanoseconds // SECOND, nsec=nanoseconds % SECOND)
