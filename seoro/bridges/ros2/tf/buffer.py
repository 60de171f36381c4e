"""All frames, and where they are in each other."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

from seoro.bridges.ros2.interfaces.errors import near
from seoro.bridges.ros2.tf.edges import SECOND, Edge, MovingEdge, Sample, StaticEdge
from seoro.bridges.ros2.tf.errors import FramesNotConnected, OutOfReach, TransformError, UnknownFrame
from seoro.bridges.ros2.tf.transform import IDENTITY, Transform, normalised

HISTORY: Final = 10.0  # [s], as tf2 has it
JUMP: Final = SECOND  # [ns] by which stamps of a frame go back when time has been set back
MOST_FRAMES: Final = 10_000
_SHOWN: Final = 12  # frames that messages list


@dataclass(frozen=True, slots=True)
class Stamped:
    """Where a frame is in another one, and when that was.

    Attributes:
        transform: Where.
        stamp: [ns]; None if nothing between them ever moves.
    """

    transform: Transform
    stamp: int | None


@dataclass(frozen=True)
class _Way:
    """What leads from a frame up to the root of its tree.

    Attributes:
        transforms: Where the frame is in each frame on the way, itself first, but in none of those that are in
            each other in a circle.
        end: Why it is not known how it goes on; None at the root.
    """

    transforms: dict[str, Transform]
    end: TransformError | None


class TransformBuffer:
    """Frames over the last seconds. Static ones stay forever.

    Names of frames have no slash at the beginning; one that is given is left out, as in tf2.

    Args:
        history: [s] for which it is known where frames were.
        on_note: Is told, once for each frame, of what cannot be, and when time was set back.
    """

    def __init__(self, history: float = HISTORY, on_note: Callable[[str], None] = lambda text: None) -> None:
        self._history = round(history * SECOND)
        self._on_note = on_note
        self._edges: dict[str, Edge] = {}
        self._told: set[str] = set()

    def put_message(self, message: Any, *, is_static: bool = False) -> None:
        """Take over a `tf2_msgs/msg/TFMessage`.

        Args:
            message: The message, decoded.
            is_static: Whether it came on `/tf_static`.
        """
        for stamped in message.transforms:
            header, moved, turned = stamped.header, stamped.transform.translation, stamped.transform.rotation
            rotation = normalised((turned.x, turned.y, turned.z, turned.w))
            if rotation is None or not all(map(math.isfinite, (moved.x, moved.y, moved.z))):
                self._note_once(f"where `{stamped.child_frame_id}` is in `{header.frame_id}` is no transform")
                continue
            transform = Transform((moved.x, moved.y, moved.z), rotation)
            stamp = header.stamp.sec * SECOND + header.stamp.nanosec
            self.put(header.frame_id, stamped.child_frame_id, transform, None if is_static else stamp)

    def put(self, parent: str, child: str, transform: Transform, stamp: int | None) -> None:
        """Take over where a frame is.

        Args:
            parent: The frame in which it is.
            child: The frame.
            transform: Where.
            stamp: [ns] at which; forever when None.
        """
        parent, child = _bare(parent), _bare(child)
        known = self._edges.get(child)
        if not parent or not child or parent == child:
            self._note_once(f"`{child}` in `{parent}`: frames have names, and are in other frames")
        elif known is None and len(self._edges) >= MOST_FRAMES:
            self._note_once(f"there are more than {MOST_FRAMES} frames; others are not followed")
        elif stamp is None:
            self._edges[child] = StaticEdge(Sample(0, parent, transform))
        elif isinstance(known, MovingEdge) and stamp > known.newest - JUMP:
            known.put(Sample(stamp, parent, transform))
        else:
            if isinstance(known, MovingEdge):
                self._on_note(
                    f"time was set back: `{child}` was at {known.newest / SECOND:.3f} s, and is at"
                    f" {stamp / SECOND:.3f} s; where frames were before is forgotten"
                )
                self.clear()
            self._edges[child] = MovingEdge(child, Sample(stamp, parent, transform), self._history)

    def clear(self) -> None:
        """Forget all but static frames."""
        self._edges = {child: edge for child, edge in self._edges.items() if isinstance(edge, StaticEdge)}

    @property
    def frames(self) -> tuple[str, ...]:
        """All frames, sorted."""
        return tuple(sorted(self._edges.keys() | {edge.parent for edge in self._edges.values()}))

    @property
    def parents(self) -> dict[str, str]:
        """In which frame each is now, but the roots of the trees."""
        return {child: edge.parent for child, edge in sorted(self._edges.items())}

    def lookup(self, frame: str, parent: str, time: int | None = None) -> Stamped:
        """Where a frame is in another one, which need not be its own parent.

        Args:
            frame: The frame.
            parent: In which.
            time: [ns] at which; the latest one at which that is known when None.

        Raises:
            UnknownFrame: There is no such frame; names what there is.
            FramesNotConnected: They are in different trees, or in a circle.
            OutOfReach: It is not known for that time.
        """
        frame, parent = _bare(frame), _bare(parent)
        for name in (frame, parent):
            self._check_known(name)
        stamp = self._latest(frame, parent) if time is None else time
        up, down = self._way(frame, stamp), self._way(parent, stamp)
        for common, transform in up.transforms.items():
            if common in down.transforms:
                return Stamped(down.transforms[common].inverse() @ transform, stamp)
        raise up.end or down.end or self._not_connected(frame, parent)

    def find(self, frame: str, parent: str, time: int | None = None) -> Stamped | None:
        """Where a frame is in another one, or None as long as that is not known; see `lookup`."""
        try:
            return self.lookup(frame, parent, time)
        except TransformError:
            return None

    def _latest(self, frame: str, parent: str) -> int | None:
        """The latest stamp for which all is known between two frames; None if nothing there moves."""
        up, down = self._ancestors(frame), self._ancestors(parent)
        common = next((name for name in up if name in down), None)
        if common is None:
            raise self._not_connected(frame, parent)
        between = (*up[: up.index(common)], *down[: down.index(common)])
        edges = (self._edges[name] for name in between)
        return min((edge.newest for edge in edges if isinstance(edge, MovingEdge)), default=None)

    def _ancestors(self, frame: str) -> list[str]:
        """A frame and those that it is in now, up to the root."""
        found = [frame]
        while (edge := self._edges.get(found[-1])) is not None and edge.parent not in found:
            found.append(edge.parent)
        return found

    def _way(self, frame: str, time: int | None) -> _Way:
        transforms, transform = {frame: IDENTITY}, IDENTITY
        while (edge := self._edges.get(frame)) is not None:
            try:
                sample = edge.at(0 if time is None else time)
            except OutOfReach as reason:
                return _Way(transforms, reason)
            frame, transform = sample.parent, sample.transform @ transform
            if frame in transforms:
                circle = tuple(transforms)[tuple(transforms).index(frame) :]
                for name in circle:
                    del transforms[name]
                return _Way(transforms, FramesNotConnected(f"{_listed(circle)} are in each other, in a circle"))
            transforms[frame] = transform
        return _Way(transforms, None)

    def _check_known(self, frame: str) -> None:
        if frame in self._edges or any(edge.parent == frame for edge in self._edges.values()):
            return
        if not self._edges:
            raise UnknownFrame(f"there is no frame `{frame}`: nothing was told of any frame")
        hint = near(frame, self.frames)
        raise UnknownFrame(f"there is no frame `{frame}`; {hint or f'there are {_listed(self.frames)}'}")

    def _not_connected(self, frame: str, parent: str) -> FramesNotConnected:
        root, other = self._ancestors(frame)[-1], self._ancestors(parent)[-1]
        return FramesNotConnected(
            f"`{frame}` and `{parent}` are not connected: {_listed(self._tree(root))} are below `{root}`,"
            f" {_listed(self._tree(other))} below `{other}`"
        )

    def _tree(self, root: str) -> tuple[str, ...]:
        return tuple(name for name in self.frames if name != root and root in self._ancestors(name))

    def _note_once(self, text: str) -> None:
        if text not in self._told and len(self._told) < MOST_FRAMES:
            self._told.add(text)
            self._on_note(text)


def _bare(name: str) -> str:
    return name.removeprefix("/")


def _listed(names: tuple[str, ...]) -> str:
    shown = ", ".join(f"`{name}`" for name in names[:_SHOWN])
    return f"{shown} and {len(names) - _SHOWN} others" if len(names) > _SHOWN else shown or "no frames"
