"""Values of Foxglove's messages from values of a trace."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from foxglove.messages import Color, Pose, Quaternion, Timestamp, Vector3

from seoro.robotics.transform import Transform

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
    found = _transform(frame).inverse() @ _transform(pose)
    return [*found.translation, *found.rotation]


def _transform(pose: Sequence[float]) -> Transform:
    x, y, z, qx, qy, qz, qw = pose
    return Transform((x, y, z), (qx, qy, qz, qw))


def to_color(text: str) -> Color:
    """Convert a colour `#rrggbb`."""
    red, green, blue = (int(text[at : at + 2], 16) / 255.0 for at in (1, 3, 5))
    return Color(r=red, g=green, b=blue, a=1.0)


def to_timestamp(nanoseconds: int) -> Timestamp:
    """Convert a time since the epoch [ns]."""
    return Timestamp(sec=nanoseconds // SECOND, nsec=nanoseconds % SECOND)
