"""Poses of frames as actions wait for them; see `contracts.ros2.RosFrames`."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import TypeAlias

from seoro.bridges.ros2.tf.buffer import Stamped, TransformBuffer
from seoro.bridges.ros2.tf.edges import SECOND
from seoro.bridges.ros2.tf.errors import TransformError
from seoro.runtime.contracts import ros2 as contract

Find: TypeAlias = Callable[[], Stamped | None]


class FramePoses:
    """Frames of a buffer.

    Args:
        buffer: Their transforms.
        wait_for: Waits until a function returns a pose, after each change of the buffer.
    """

    def __init__(self, buffer: TransformBuffer, wait_for: Callable[[Find], Awaitable[Stamped | None]]) -> None:
        self.buffer = buffer
        self._wait_for = wait_for
        self._last: dict[tuple[str, str], Stamped] = {}

    async def next_pose(self, frame: str, parent: str) -> contract.FramePose:
        """Wait for a pose of a frame in another one that differs from the last returned pose."""
        last = self._last.get((frame, parent))

        def changed() -> Stamped | None:
            found = self.buffer.find(frame, parent)
            return found if found != last else None

        found = await self._wait_for(changed)
        assert found is not None, "the condition is true"
        self._last[frame, parent] = found
        stamp = None if found.stamp is None else found.stamp / SECOND
        return contract.FramePose(found.transform.translation, found.transform.rotation, stamp)

    def describe_absence(self, frame: str, parent: str) -> str:
        """Return why the pose of a frame is unknown; empty if it is known."""
        try:
            self.buffer.lookup(frame, parent)
        except TransformError as error:
            return str(error)
        return ""
