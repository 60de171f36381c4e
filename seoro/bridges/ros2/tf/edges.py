"""Where a frame was in its parent, over time."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from dataclasses import dataclass
from operator import attrgetter
from typing import Final, TypeAlias

from seoro.bridges.ros2.tf.errors import OutOfReach
from seoro.bridges.ros2.tf.transform import Transform, interpolate

SECOND: Final = 1_000_000_000  # [ns]

_stamp = attrgetter("stamp")


@dataclass(frozen=True, slots=True)
class Sample:
    """Where a frame was in its parent.

    Attributes:
        stamp: [ns] since the epoch, or of the simulator's time.
        parent: The frame in which it was.
        transform: Where.
    """

    stamp: int
    parent: str
    transform: Transform


@dataclass(frozen=True, slots=True)
class StaticEdge:
    """A frame that does not move in its parent."""

    sample: Sample

    @property
    def parent(self) -> str:
        """The frame in which it is."""
        return self.sample.parent

    def at(self, time: int) -> Sample:
        """Where the frame is, at any time."""
        return self.sample


class MovingEdge:
    """A frame that moves: samples in the order of their stamps.

    Args:
        child: The frame.
        first: Where it was first.
        history: [ns] for which samples are kept.
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
        """The frame in which it is now."""
        return self._samples[-1].parent

    def put(self, sample: Sample) -> None:
        """Add a sample; one of the same stamp takes its place."""
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
        """Where the frame was at a time [ns], between samples.

        Raises:
            OutOfReach: There are only samples before, or after.
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
            f"where `{self._child}` is in `{nearest.parent}` is known {which} {nearest.stamp / SECOND:.3f} s,"
            f" {by / SECOND:.3f} s from {time / SECOND:.3f} s"
        )


Edge: TypeAlias = StaticEdge | MovingEdge
