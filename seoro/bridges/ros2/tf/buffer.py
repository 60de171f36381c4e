"""Buffer of the transforms between all frames."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

from seoro.bridges.ros2.interfaces.errors import near
from seoro.bridges.ros2.tf.edges import SECOND, Edge, MovingEdge, Sample, StaticEdge
from seoro.bridges.ros2.tf.errors import FramesNotConnected, OutOfReach, TransformError, UnknownFrame
from seoro.robotics.transform import IDENTITY, Transform, normalised

HISTORY: Final = 10.0  # [s], as in tf2
JUMP: Final = SECOND  # [ns]; stamps of a frame that go back further mean that the time was set back
MAX_FRAMES: Final = 10_000
_SHOWN: Final = 12  # listed frames in messages


@dataclass(frozen=True, slots=True)
class Stamped:
    """Transform between two frames at a time.

    Attributes:
        transform: Transform.
        stamp: Time [ns]; None if all frames between them are static.
    """

    transform: Transform
    stamp: int | None


@dataclass(frozen=True)
class _Chain:
    """Chain of transforms from a frame up to the root of its tree.

    Attributes:
        transforms: Transforms to each ancestor, the frame itself first; without frames of a cycle.
        end: Reason why the chain ends; None at the root.
    """

    transforms: dict[str, Transform]
    end: TransformError | None


class TransformBuffer:
    """Transforms of the last seconds, and static transforms.

    A slash at the beginning of a frame name is ignored, as in tf2.

    Args:
        history: Time for which transforms are kept [s].
        on_note: Called once for each frame with invalid data, and when the time was set back.
    """

    def __init__(self, history: float = HISTORY, on_note: Callable[[str], None] = lambda text: None) -> None:
        self._history = round(history * SECOND)
        self._on_note = on_note
        self._edges: dict[str, Edge] = {}
        self._noted: set[str] = set()

    def put_message(self, message: Any, *, is_static: bool = False) -> None:
        """Add the transforms of a decoded `tf2_msgs/msg/TFMessage`, from `/tf` or `/tf_static`."""
        for stamped in message.transforms:
            header, moved, turned = stamped.header, stamped.transform.translation, stamped.transform.rotation
            rotation = normalised((turned.x, turned.y, turned.z, turned.w))
            if rotation is None or not all(map(math.isfinite, (moved.x, moved.y, moved.z))):
                self._note_once(f"invalid transform of `{stamped.child_frame_id}` in `{header.frame_id}`")
                continue
            transform = Transform((moved.x, moved.y, moved.z), rotation)
            stamp = header.stamp.sec * SECOND + header.stamp.nanosec
            self.put(header.frame_id, stamped.child_frame_id, transform, None if is_static else stamp)

    def put(self, parent: str, child: str, transform: Transform, stamp: int | None) -> None:
        """Add the transform of a frame.

        Args:
            parent: Parent of the frame.
            child: The frame.
            transform: Transform of the frame in its parent.
            stamp: Time of the transform [ns]; None for a static transform.
        """
        parent, child = _bare(parent), _bare(child)
        known = self._edges.get(child)
        if not parent or not child or parent == child:
            self._note_once(f"invalid transform of `{child}` in `{parent}`: expected the names of two frames")
        elif known is None and len(self._edges) >= MAX_FRAMES:
            self._note_once(f"more than {MAX_FRAMES} frames; further frames are ignored")
        elif stamp is None:
            self._edges[child] = StaticEdge(Sample(0, parent, transform))
        elif isinstance(known, MovingEdge) and stamp > known.newest - JUMP:
            known.put(Sample(stamp, parent, transform))
        else:
            if isinstance(known, MovingEdge):
                self._on_note(
                    f"time was set back from {known.newest / SECOND:.3f} s to {stamp / SECOND:.3f} s (`{child}`); "
                    "earlier transforms are dropped"
                )
                self.clear()
            self._edges[child] = MovingEdge(child, Sample(stamp, parent, transform), self._history)

    def clear(self) -> None:
        """Drop all transforms but the static ones."""
        self._edges = {child: edge for child, edge in self._edges.items() if isinstance(edge, StaticEdge)}

    @property
    def frames(self) -> tuple[str, ...]:
        """All frames, sorted."""
        return tuple(sorted(self._edges.keys() | {edge.parent for edge in self._edges.values()}))

    @property
    def parents(self) -> dict[str, str]:
        """Present parents of the frames, except roots."""
        return {child: edge.parent for child, edge in sorted(self._edges.items())}

    def lookup(self, frame: str, parent: str, time: int | None = None) -> Stamped:
        """Return the transform of a frame in any other frame.

        Args:
            frame: The frame.
            parent: Target frame.
            time: Time of the transform [ns]; None for the latest known one.

        Raises:
            UnknownFrame: A frame is unknown; the message lists the known frames.
            FramesNotConnected: The frames are in different trees, or in a cycle.
            OutOfReach: The transform is unknown at that time.
        """
        frame, parent = _bare(frame), _bare(parent)
        for name in (frame, parent):
            self._check_known(name)
        stamp = self._latest(frame, parent) if time is None else time
        up, down = self._chain(frame, stamp), self._chain(parent, stamp)
        for common, transform in up.transforms.items():
            if common in down.transforms:
                return Stamped(down.transforms[common].inverse() @ transform, stamp)
        raise up.end or down.end or self._not_connected(frame, parent)

    def find(self, frame: str, parent: str, time: int | None = None) -> Stamped | None:
        """Return the transform of a frame in another one, or None if unknown; see `lookup`."""
        try:
            return self.lookup(frame, parent, time)
        except TransformError:
            return None

    def _latest(self, frame: str, parent: str) -> int | None:
        """Return the latest time at which a transform is known; None if it is static."""
        up, down = self._ancestors(frame), self._ancestors(parent)
        common = next((name for name in up if name in down), None)
        if common is None:
            raise self._not_connected(frame, parent)
        between = (*up[: up.index(common)], *down[: down.index(common)])
        edges = (self._edges[name] for name in between)
        return min((edge.newest for edge in edges if isinstance(edge, MovingEdge)), default=None)

    def _ancestors(self, frame: str) -> list[str]:
        """Return a frame and its present ancestors up to the root."""
        found = [frame]
        while (edge := self._edges.get(found[-1])) is not None and edge.parent not in found:
            found.append(edge.parent)
        return found

    def _chain(self, frame: str, time: int | None) -> _Chain:
        transforms, transform = {frame: IDENTITY}, IDENTITY
        while (edge := self._edges.get(frame)) is not None:
            try:
                sample = edge.at(0 if time is None else time)
            except OutOfReach as reason:
                return _Chain(transforms, reason)
            frame, transform = sample.parent, sample.transform @ transform
            if frame in transforms:
                cycle = tuple(transforms)[tuple(transforms).index(frame) :]
                for name in cycle:
                    del transforms[name]
                return _Chain(transforms, FramesNotConnected(f"the frames {_listed(cycle)} form a cycle"))
            transforms[frame] = transform
        return _Chain(transforms, None)

    def _check_known(self, frame: str) -> None:
        if frame in self._edges or any(edge.parent == frame for edge in self._edges.values()):
            return
        if not self._edges:
            raise UnknownFrame(f"unknown frame `{frame}`: no frame was published")
        hint = near(frame, self.frames) or f"known frames: {_listed(self.frames)}"
        raise UnknownFrame(f"unknown frame `{frame}`; {hint}")

    def _not_connected(self, frame: str, parent: str) -> FramesNotConnected:
        root, other = self._ancestors(frame)[-1], self._ancestors(parent)[-1]
        return FramesNotConnected(
            f"`{frame}` and `{parent}` are not connected: {_listed(self._tree(root))} are below `{root}`,"
            f" {_listed(self._tree(other))} below `{other}`"
        )

    def _tree(self, root: str) -> tuple[str, ...]:
        return tuple(name for name in self.frames if name != root and root in self._ancestors(name))

    def _note_once(self, text: str) -> None:
        if text not in self._noted and len(self._noted) < MAX_FRAMES:
            self._noted.add(text)
            self._on_note(text)


def _bare(name: str) -> str:
    return name.removeprefix("/")


def _listed(names: tuple[str, ...]) -> str:
    shown = ", ".join(f"`{name}`" for name in names[:_SHOWN])
    return f"{shown} and {len(names) - _SHOWN} others" if len(names) > _SHOWN else shown or "no frames"
