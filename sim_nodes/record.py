"""What is remembered of a run for its picture."""

from __future__ import annotations

from dataclasses import dataclass, field

from sim_nodes.geometry import Pose2
from sim_nodes.stateful import Stateful

STEP = 0.01  # [m] between points of a path


@dataclass
class RobotRecord(Stateful):
    """Where a robot has really been: its start, the points it passed, and the goals it was given."""

    STATE = ("start", "path", "times", "goals")

    start: Pose2
    path: list[tuple[float, float]] = field(default_factory=list)  # [m], in the map
    times: list[float] = field(default_factory=list)  # [s], of the points of the path
    goals: list[Pose2] = field(default_factory=list)

    def passed(self, pose: Pose2, time: float) -> None:
        """Note where the robot is."""
        if not self.path or pose.distance(*self.path[-1]) >= STEP:
            self.path.append((pose.x, pose.y))
            self.times.append(time)
