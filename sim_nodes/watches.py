"""Conditions on robots and entities that are checked in every tick and reported once, when they become true.

They name what they are about, so that they can be saved, and go on in a world that is reset.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import Any, Protocol

from seoro.bridges.wire import Outcome
from sim_nodes.geometry import Pose2
from sim_nodes.sensors.feed import Feed


class Watched(Protocol):
    """What watches look at."""

    @property
    def tick(self) -> int:
        """The last tick."""

    def feed(self, robot: str, sensor: str) -> Feed[Any]:
        """The way of a sensor's samples."""

    def pose(self, frame: str) -> Pose2 | None:
        """The pose of a frame in the map, None when it has none."""

    def travelled(self, robot: str) -> float:
        """What the odometry of a robot has counted [m]."""

    def joint_position(self, robot: str, joint: str) -> float:
        """Where a joint of a robot's arm or gripper is [rad, m]."""


class Watch(ABC):
    """A condition on a simulation; frozen data."""

    @abstractmethod
    def holds(self, world: Watched) -> bool:
        """Whether it is true now."""

    @property
    def of_robot(self) -> str | None:
        """The robot that it is about, if it is about one."""
        robot: str | None = getattr(self, "robot", None)
        return robot

    def carried_over(self, before: Watched, now: Watched) -> Watch:
        """The same condition in a world whose robots are others, or what they were at another time."""
        return self

    def result(self, world: Watched) -> tuple[Outcome, str]:
        """What is told when it has become true."""
        return Outcome.SUCCEEDED, ""


@dataclass(frozen=True)
class ProximityWatch(Watch):
    """True when a frame is near a point that is given in another frame."""

    frame: str
    parent: str
    x: float  # [m], in the parent
    y: float
    threshold: float  # [m]

    def holds(self, world: Watched) -> bool:
        """Whether it is true now."""
        frame, parent = world.pose(self.frame), world.pose(self.parent)
        if frame is None or parent is None:
            return False
        point = parent.compose(Pose2(self.x, self.y, 0.0))
        return frame.distance(point.x, point.y) <= self.threshold


@dataclass(frozen=True)
class DistanceWatch(Watch):
    """True when the odometry of a robot has reached a count."""

    robot: str
    target: float  # [m]

    def holds(self, world: Watched) -> bool:
        """Whether it is true now."""
        return world.travelled(self.robot) >= self.target

    def carried_over(self, before: Watched, now: Watched) -> DistanceWatch:
        """With as much left to go as there was."""
        return replace(self, target=self.target - before.travelled(self.robot) + now.travelled(self.robot))


@dataclass(frozen=True)
class LocalisationWatch(Watch):
    """True when a robot knows where it is."""

    robot: str

    def holds(self, world: Watched) -> bool:
        """Whether it is true now."""
        return world.pose(f"{self.robot}/base_link") is not None


@dataclass(frozen=True)
class JointWatch(Watch):
    """True when a joint is near a position, or has passed it, which a fast one does between two looks."""

    robot: str
    joint: str
    target: float  # [rad, m]
    tolerance: float  # [rad, m]
    from_above: bool  # whether it comes from a position that is greater

    def holds(self, world: Watched) -> bool:
        """Whether it is true now."""
        position = world.joint_position(self.robot, self.joint)
        return abs(position - self.target) <= self.tolerance or (position > self.target) != self.from_above

    def carried_over(self, before: Watched, now: Watched) -> JointWatch:
        """Coming from where the joint is now."""
        return replace(self, from_above=now.joint_position(self.robot, self.joint) > self.target)
