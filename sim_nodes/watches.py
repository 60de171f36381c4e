"""Conditions on robots and entities that are checked in every tick and reported once, when they become true.

They name what they are about, so that they can be saved, and go on in a world that is reset.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Container
from dataclasses import dataclass, replace
from typing import Any, Protocol

from seoro.bridges.wire import Outcome, Result
from seoro.bridges.wire.refusal import RequestRefused, listed
from sim_nodes.geometry import Pose2
from sim_nodes.goals import Ended
from sim_nodes.sensors.feed import Feed
from sim_nodes.stateful import Stateful

MAX_WATCHES = 1000


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


class Watches(Stateful):
    """The watches of a simulation, by the ids that clients gave them."""

    STATE = ("_watches",)

    def __init__(self) -> None:
        self._watches: dict[str, Watch] = {}

    def __bool__(self) -> bool:
        return bool(self._watches)

    def __contains__(self, identifier: str) -> bool:
        return identifier in self._watches

    @property
    def robots(self) -> frozenset[str]:
        """The robots that something is watched of."""
        return frozenset(robot for watch in self._watches.values() if (robot := watch.of_robot))

    def add(self, identifier: str, watch: Watch) -> None:
        """Have a watch, by an id that no other has.

        Raises:
            RequestRefused: There are too many.
        """
        if len(self._watches) >= MAX_WATCHES:
            raise RequestRefused(Result.OPERATION_FAILED, f"there are {MAX_WATCHES} watches already: cancel some")
        self._watches[identifier] = watch

    def cancel(self, identifier: str) -> None:
        """Forget a watch.

        Raises:
            RequestRefused: There is none.
        """
        if identifier not in self._watches:
            raise RequestRefused(
                Result.NOT_FOUND, f"there is no watch {identifier!r}: waiting are {listed(self._watches)}"
            )
        del self._watches[identifier]

    def forget(self, prefix: str) -> None:
        """Forget all whose ids begin so."""
        self._watches = {name: watch for name, watch in self._watches.items() if not name.startswith(prefix)}

    def take_true(self, world: Watched) -> list[Ended]:
        """Forget those that have become true, and say what is told of them."""
        true = [identifier for identifier, watch in self._watches.items() if watch.holds(world)]
        return [Ended(identifier, *self._watches.pop(identifier).result(world)) for identifier in true]

    def carry_over(self, world: Watched) -> None:
        """Watch on in a world whose robots have been reset."""
        self._watches = {name: watch.carried_over(world, world) for name, watch in self._watches.items()}

    def take_over(self, watches: Watches, before: Watched, now: Watched, robots: Container[str]) -> None:
        """Have those that there were in a world before, as they are saved here if they are.

        Args:
            watches: Those that there were.
            before: The world before.
            now: This one.
            robots: The robots that are here.
        """
        saved, self._watches = self._watches, {}
        for identifier, watch in watches._watches.items():
            is_here = watch.of_robot is None or watch.of_robot in robots
            over = watch.carried_over(before, now) if is_here else watch
            self._watches[identifier] = saved.get(identifier) or over
