"""Values of ROS 2 messages from values of a trace."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

Values = dict[str, Any]

MAP: Final = "map"
_SECOND: Final = 1_000_000_000  # [ns]


def time_value(at: int) -> Values:
    """Convert a time since the epoch [ns]."""
    return {"sec": at // _SECOND, "nanosec": at % _SECOND}


def stamped(at: int, frame: str) -> Values:
    """Return the header of a message, by its member."""
    return {"header": {"stamp": time_value(at), "frame_id": frame}}


def vector(x: float, y: float, z: float) -> Values:
    """Return a vector or point."""
    return {"x": float(x), "y": float(y), "z": float(z)}


def pose_value(values: Sequence[float]) -> Values:
    """Convert x, y, z and a quaternion x, y, z, w; further values are ignored."""
    x, y, z, *rotation = values[:7]
    return {"position": vector(x, y, z), "orientation": _quaternion(rotation)}


def transform_value(at: int, parent: str, child: str, pose: Sequence[float]) -> Values:
    """Return the transform of a frame in its parent, with its header."""
    x, y, z, *rotation = pose[:7]
    transform = {"translation": vector(x, y, z), "rotation": _quaternion(rotation)}
    return stamped(at, parent) | {"child_frame_id": child, "transform": transform}


def _quaternion(values: Sequence[float]) -> Values:
    return dict(zip("xyzw", map(float, values), strict=True))
