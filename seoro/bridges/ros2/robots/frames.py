"""Where frames of a robot are, by the transforms that it publishes."""

from __future__ import annotations

import logging
import math

from seoro.bridges.ros2 import geometry
from seoro.bridges.ros2.interfaces import Message
from seoro.bridges.ros2.tf import TransformBuffer
from seoro.bridges.wire import Pose, Vector3
from seoro.changes import Changes

log = logging.getLogger(__name__)


class Frames:
    """The frames of a robot.

    Attributes:
        changes: Tells of each change.
    """

    def __init__(self) -> None:
        self._buffer = TransformBuffer(on_note=log.warning)
        self.changes = Changes()

    @property
    def names(self) -> frozenset[str]:
        """All frames that there are."""
        return frozenset(self._buffer.frames)

    def take(self, message: Message) -> None:
        """Take in a `tf2_msgs/TFMessage` of what moves."""
        self._buffer.put_message(message)
        self.changes.tell()

    def take_static(self, message: Message) -> None:
        """Take in a `tf2_msgs/TFMessage` of what does not move."""
        self._buffer.put_message(message, is_static=True)
        self.changes.tell()

    def forget(self) -> None:
        """Forget where frames were, but for those that never move."""
        self._buffer.clear()
        self.changes.tell()

    def pose(self, frame: str, parent: str) -> Pose | None:
        """The pose of a frame in another; None if that is not known."""
        found = self._buffer.find(frame, parent)
        if found is None:
            return None
        x, y, z = found.transform.translation
        turned = geometry.orientation(geometry.Quaternion(*found.transform.rotation))
        return Pose(position=Vector3(x=x, y=y, z=z), orientation=turned)

    def distance(self, frame: str, parent: str, x: float, y: float) -> float:
        """How far a frame is from a point of another [m], in the plane; infinite if that is not known."""
        found = self._buffer.find(frame, parent)
        return math.inf if found is None else math.dist(found.transform.translation[:2], (x, y))
