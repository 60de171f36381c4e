"""Transforms of a frame in its parent, over time."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from dataclasses import dataclass
from operator import attrgetter
from typing import Final, TypeAlias

from seoro.bridges.ros2.tf.errors import OutOfReach
from seoro.robotics.transform import Transform, interpolate

SECOND: Final = 1_000_000_000  # [ns]

_stamp = attrgetter("stamp")


@dataclass(frozen=True, slots=True)
class Sample:
    """Transform of a frame in its parent.

    Attributes:
        stamp: Time [ns since the epoch], or of the simulator.
        parent: Parent of the frame.
        transform: Transform.
    """

    stamp: int
    parent: str
    transform: Transform


@dataclass(frozen=True, slots=True)
class StaticEdge:
    """Transform of a static frame."""

    sample: Sample

    @property
    def parent(self) -> str:
        """Parent of the frame."""
        return self.sample.parent

    def at(self, time: int) -> Sample:
        """Return the transform, which is the same at any time."""
        return self.sample


class MovingEdge:
    """Transforms of a moving frame: samples in the order of their stamps.

    Args:
        child: The frame.
        first: First sample.
        history: Time for which samples are kept [ns].
    """

    def __init__(self, child: str, first: Sample, history: int) -> None:
        self._child = child
        self._samples = [first]
        self._history = history

    @property
    def newest(self) -> int:
        """Stamp [ns] of the newest sample."""
        return self._samples[-1].stamp

    @property
    def parent(self) -> str:
        """Present parent of the frame."""
        return self._samples[-1].parent

    def put(self, sample: Sample) -> None:
        """Add a sample, replacing one with the same stamp."""
        samples = self._samples
        if sample.stamp > samples[-1].stamp:
            samples.append(sample)
            oldest = sample.stamp - self._history
            if samples[0].stamp < oldest:
                del samples[: bisect_left(samples, oldest, key=_stamp)]
            return
        place = bisect_left(samples, sample.stamp, key=_stamp)
        if samples[place].stamp == sample.stamp:
            samples[place] = sample
        elif sample.stamp >= samples[-1].stamp - self._history:
            samples.insert(place, sample)

    def at(self, time: int) -> Sample:
        """Return the transform at a time [ns], interpolated between samples.

        Raises:
            OutOfReach: All samples are earlier, or all are later.
        """
        samples = self._samples
        after = bisect_right(samples, time, key=_stamp)
        if after == 0:
            raise self._out_of_reach(time, samples[0], "from", samples[0].stamp - time)
        before = samples[after - 1]
        if before.stamp == time:
            return before
        if after == len(samples):
            raise self._out_of_reach(time, before, "up to", time - before.stamp)
        later = samples[after]
        if later.parent != before.parent:
            return before
        share = (time - before.stamp) / (later.stamp - before.stamp)
        return Sample(time, before.parent, interpolate(before.transform, later.transform, share))

    def _out_of_reach(self, time: int, nearest: Sample, which: str, by: int) -> OutOfReach:
        return OutOfReach(
            f"the pose of `{self._child}` in `{nearest.parent}` is known {which} {nearest.stamp / SECOND:.3f} s,"
            f" {by / SECOND:.3f} s from {time / SECOND:.3f} s"
        )


Edge: TypeAlias = StaticEdge | MovingEdge
