"""Count of recoveries without progress, after which a goal is aborted."""

from __future__ import annotations

from sim_nodes.geometry import Pose2
from sim_nodes.stateful import Stateful


class Retries(Stateful):
    """The recoveries of a goal.

    A recovery is one without progress if it follows another one and the robot has hardly moved on. It is also one
    without progress if the robot recovered near that place before. So a robot that goes to and fro between blocked
    passages gives up.

    Args:
        radius: Distance up to which a robot has hardly moved on [m].

    Attributes:
        in_a_row: Recoveries without moving on.
    """

    STATE = ("in_a_row", "_last", "_places", "_repeated")

    def __init__(self, radius: float) -> None:
        self._radius = radius
        self.begin(Pose2(0.0, 0.0, 0.0))

    def begin(self, pose: Pose2) -> None:
        """Begin a goal at a pose of the robot."""
        self.in_a_row = 0
        self._last = pose
        self.begin_leg()

    def begin_leg(self) -> None:
        """Forget the places, because the way to the next pose of the goal is another one."""
        self._places: list[Pose2] = []
        self._repeated = 0  # recoveries near earlier ones

    @property
    def without_progress(self) -> int:
        """Number of recoveries without progress."""
        return max(self.in_a_row, self._repeated)

    def add(self, pose: Pose2) -> None:
        """Add a recovery at a pose."""
        self._last = pose
        self.in_a_row += 1
        self._repeated += any(self._is_near(pose, other) for other in self._places)
        self._places.append(pose)

    def move_on(self, pose: Pose2) -> None:
        """Note that the robot makes progress at a pose."""
        if not self._is_near(pose, self._last):
            self.in_a_row = 0

    def _is_near(self, pose: Pose2, other: Pose2) -> bool:
        return pose.distance(other.x, other.y) <= self._radius
