"""Poses of the frames of a robot, from its transforms."""

from __future__ import annotations

import logging
import math

from seoro.bridges.ros2 import geometry
from seoro.bridges.ros2.interfaces import Message
from seoro.bridges.ros2.tf import TransformBuffer
from seoro.bridges.wire import Pose3D, Position3D
from seoro.robotics.geometry import Quaternion

log = logging.getLogger(__name__)


class Frames:
    """Frames of a robot."""

    def __init__(self) -> None:
        self._buffer = TransformBuffer(on_note=log.warning)

    @property
    def names(self) -> frozenset[str]:
        """Names of all known frames."""
        return frozenset(self._buffer.frames)

    def put(self, message: Message, *, is_static: bool = False) -> None:
        """Add the transforms of a `tf2_msgs/TFMessage`."""
        self._buffer.put_message(message, is_static=is_static)

    def forget(self) -> None:
        """Forget all transforms but the static ones."""
        self._buffer.clear()

    def pose(self, frame: str, parent: str) -> Pose3D | None:
        """Return the pose of a frame in another one; None if it is unknown."""
        found = self._buffer.find(frame, parent)
        if found is None:
            return None
        x, y, z = found.transform.translation
        orientation = geometry.orientation(Quaternion(*found.transform.rotation))
        return Pose3D(Position3D(x, y, z), orientation)

    def distance(self, frame: str, parent: str, x: float, y: float) -> float:
        """Return the distance of a frame from a point of another one [m], in the plane; infinite if unknown."""
        found = self._buffer.find(frame, parent)
        return math.inf if found is None else math.dist(found.transform.translation[:2], (x, y))
