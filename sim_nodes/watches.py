"""Conditions on robots that are checked in every tick and reported once, when they become true."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from sim_nodes.geometry import Pose2

FramePose = Callable[[], Pose2 | None]
"""The pose of a frame in the map, None as long as it has none."""


@dataclass(frozen=True)
class ProximityWatch:
    """True when a frame is near a point that is given in another frame."""

    frame: FramePose
    parent: FramePose
    x: float  # [m], in the parent
    y: float
    threshold: float  # [m]

    def holds(self) -> bool:
        """Whether it is true now."""
        frame, parent = self.frame(), self.parent()
        if frame is None or parent is None:
            return False
        point = parent.compose(Pose2(self.x, self.y, 0.0))
        return frame.distance(point.x, point.y) <= self.threshold


@dataclass(frozen=True)
class DistanceWatch:
    """True when an odometer has reached a count."""

    travelled: Callable[[], float]  # [m]
    target: float  # [m]

    def holds(self) -> bool:
        """Whether it is true now."""
        return self.travelled() >= self.target


Watch = ProximityWatch | DistanceWatch
