"""Conditions on robots and entities, checked in every tick and reported once, when they become true.

They refer to objects by name, so that they can be saved, and continue after a reset.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Container
from dataclasses import replace
from typing import Any, Protocol

from seoro.bridges.wire import Outcome
from seoro.deferred import dataclass
from sim_nodes.clearance import Clearance
from sim_nodes.geometry import Pose2
from sim_nodes.outcomes import GoalResult, operation_failed, unknown
from sim_nodes.physics import BodyState
from sim_nodes.sensors.sensor_pipeline import SensorPipeline
from sim_nodes.stateful import Stateful

MAX_WATCHES = 1000


class Watched(Protocol):
    """The simulation as seen by watches."""

    @property
    def tick(self) -> int:
        """The last tick."""

    def pipeline(self, robot: str, sensor: str) -> SensorPipeline[Any]:
        """Return the pipeline of a sensor."""

    def pose(self, frame: str) -> Pose2 | None:
        """Return the pose of a frame in `map`; None if it is unknown yet."""

    def travelled(self, robot: str) -> float:
        """Return the distance travelled by a robot's odometry [m]."""

    def joint_position(self, robot: str, joint: str) -> float:
        """Return the position of a joint of a robot's arm or gripper [rad, m]."""

    @property
    def time(self) -> float:
        """Simulation time [s]."""

    def state_of(self, entity: str) -> BodyState | None:
        """Return the state of an entity; None if it is unknown."""

    def clearance(self, robot: str, other: str) -> Clearance | None:
        """Return the clearance of a robot to another entity, or the nearest; None if one is unknown."""

    def building_position(self, name: str) -> float | None:
        """Return the opening of a door, or the height of a lift [m]; None if it is unknown."""

    def localization_error(self, robot: str) -> float | None:
        """Return the distance between a robot's estimated and true position [m]; None without an estimate."""

    def work(self, robot: str) -> float | None:
        """Return the mechanical work of a robot's motors so far [J]; None if it is unknown."""

    def measure_work(self, robot: str) -> None:
        """Measure the work of a robot in each step from now on, if the engine can."""


class Watch(ABC):
    """A condition on a simulation; frozen data."""

    @abstractmethod
    def holds(self, world: Watched) -> bool:
        """Whether the condition is true."""

    @property
    def watched_robot(self) -> str | None:
        """Robot of the condition, if there is one."""
        robot: str | None = getattr(self, "robot", None)
        return robot

    @property
    def margin(self) -> float | None:
        """Least distance of a measure to its limit, negative beyond it; None of other watches."""
        return None

    def updated(self, world: Watched) -> Watch:
        """Return the condition with sums up to the present tick."""
        return self

    def rebased(self, before: Watched, now: Watched) -> Watch:
        """Return the condition for a world with other robots, or with robots in other states."""
        return self

    def result(self, world: Watched) -> tuple[Outcome, str]:
        """Return the outcome and message to report when it has become true."""
        return Outcome.SUCCEEDED, ""


@dataclass(frozen=True)
class ProximityWatch(Watch):
    """True when a frame is near a point given in another frame."""

    frame: str
    parent: str
    x: float  # [m], in the parent frame
    y: float
    threshold: float  # [m]

    def holds(self, world: Watched) -> bool:
        """Whether the condition is true."""
        frame, parent = world.pose(self.frame), world.pose(self.parent)
        if frame is None or parent is None:
            return False
        point = parent.compose(Pose2(self.x, self.y, 0.0))
        return frame.distance(point.x, point.y) <= self.threshold


@dataclass(frozen=True)
class DistanceWatch(Watch):
    """True when the odometry of a robot has reached a distance."""

    robot: str
    target: float  # [m]

    def holds(self, world: Watched) -> bool:
        """Whether the condition is true."""
        return world.travelled(self.robot) >= self.target

    def rebased(self, before: Watched, now: Watched) -> DistanceWatch:
        """Return the condition with the same remaining distance."""
        return replace(self, target=self.target - before.travelled(self.robot) + now.travelled(self.robot))


@dataclass(frozen=True)
class LocalisationWatch(Watch):
    """True when a robot is localised."""

    robot: str

    def holds(self, world: Watched) -> bool:
        """Whether the condition is true."""
        return world.pose(f"{self.robot}/base_link") is not None


@dataclass(frozen=True)
class JointWatch(Watch):
    """True when a joint is near a position or has passed it, as a fast one does between two ticks."""

    robot: str
    joint: str
    target: float  # [rad, m]
    tolerance: float  # [rad, m]
    from_above: bool  # whether it approaches from a greater position

    def holds(self, world: Watched) -> bool:
        """Whether the condition is true."""
        position = world.joint_position(self.robot, self.joint)
        return abs(position - self.target) <= self.tolerance or (position > self.target) != self.from_above

    def rebased(self, before: Watched, now: Watched) -> JointWatch:
        """Return the condition for an approach from the present position."""
        return replace(self, from_above=now.joint_position(self.robot, self.joint) > self.target)


class Watches(Stateful):
    """The watches of a simulation by client id."""

    STATE = ("_watches",)

    def __init__(self) -> None:
        self._watches: dict[str, Watch] = {}

    def __bool__(self) -> bool:
        return bool(self._watches)

    def __contains__(self, identifier: str) -> bool:
        return identifier in self._watches

    @property
    def robots(self) -> frozenset[str]:
        """Robots with a watch."""
        return frozenset(robot for watch in self._watches.values() if (robot := watch.watched_robot))

    def add(self, identifier: str, watch: Watch) -> None:
        """Add a watch with an unused id.

        Raises:
            RequestRefused: There are too many watches.
        """
        if len(self._watches) >= MAX_WATCHES:
            raise operation_failed(f"too many watches: {MAX_WATCHES} at most; cancel some")
        self._watches[identifier] = watch

    def cancel(self, identifier: str) -> float | None:
        """Cancel a watch; return its margin.

        Raises:
            RequestRefused: The watch is unknown.
        """
        if identifier not in self._watches:
            raise unknown(f"watch {identifier!r}", "active watches", self._watches)
        return self._watches.pop(identifier).margin

    def cancel_by_prefix(self, prefix: str) -> None:
        """Cancel all watches whose ids begin with a prefix."""
        self._watches = {name: watch for name, watch in self._watches.items() if not name.startswith(prefix)}

    def pop_true(self, world: Watched) -> list[GoalResult]:
        """Remove the watches that have become true, and return their results."""
        for identifier, watch in self._watches.items():
            self._watches[identifier] = watch.updated(world)
        true = [identifier for identifier, watch in self._watches.items() if watch.holds(world)]
        return [self._pop(identifier, world) for identifier in true]

    def _pop(self, identifier: str, world: Watched) -> GoalResult:
        watch = self._watches.pop(identifier)
        return GoalResult(identifier, *watch.result(world), margin=watch.margin)

    def carry_over(self, world: Watched) -> None:
        """Continue in a world whose robots have been reset."""
        self._watches = {name: watch.rebased(world, world) for name, watch in self._watches.items()}

    def adopt(self, watches: Watches, before: Watched, now: Watched, robots: Container[str]) -> None:
        """Adopt the watches of an earlier world, or their saved state here.

        Args:
            watches: Watches of the earlier world.
            before: The earlier world.
            now: This world.
            robots: Robots of this world.
        """
        saved, self._watches = self._watches, {}
        for identifier, watch in watches._watches.items():
            is_here = watch.watched_robot is None or watch.watched_robot in robots
            over = watch.rebased(before, now) if is_here else watch
            self._watches[identifier] = saved.get(identifier) or over
