"""What is remembered of a run for its picture."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from sim_nodes.geometry import Pose2, Vector
from sim_nodes.stateful import Stateful

STEP = 0.01  # [m] between points of a path

Point = tuple[float, float]


@dataclass
class RobotRecord(Stateful):
    """Where a robot has really been: its start, the points it and its tool passed, and the goals it was given."""

    STATE = ("start", "path", "times", "goals", "tool")

    start: Pose2
    path: list[Point] = field(default_factory=list)  # [m], in the map
    times: list[float] = field(default_factory=list)  # [s], of the points of the path
    goals: list[Pose2] = field(default_factory=list)
    tool: list[Vector] = field(default_factory=list)  # [m], in the map

    def passed(self, pose: Pose2, time: float) -> None:
        """Note where the robot is."""
        if not self.path or pose.distance(*self.path[-1]) >= STEP:
            self.path.append((pose.x, pose.y))
            self.times.append(time)

    def tool_passed(self, position: Vector) -> None:
        """Note where the tool of its arm is."""
        _add(self.tool, position)


class Trails(Stateful):
    """Where bodies have been that do not move by themselves, by name.

    Attributes:
        paths: The points that they passed [m], in the map.
    """

    STATE = ("paths", "_since")

    def __init__(self) -> None:
        self.paths: dict[str, list[Vector]] = {}
        self._since: dict[str, float] = {}

    def note(self, since: Mapping[str, float], position_of: Callable[[str], Vector]) -> None:
        """Note where they are.

        Args:
            since: When each came into the world [s], by name; others are forgotten.
            position_of: Gives their positions [m].
        """
        for name in self.paths.keys() - since.keys():
            del self.paths[name], self._since[name]
        for name, time in since.items():
            if self._since.get(name) != time:
                self.paths[name], self._since[name] = [], time
            _add(self.paths[name], position_of(name))


def _add(path: list[Vector], position: Vector) -> None:
    if not path or math.dist(path[-1], position) >= STEP:
        path.append(position)
