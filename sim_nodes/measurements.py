"""What a run measures of a robot that drives, by its true poses, which the robot itself does not know."""

from __future__ import annotations

import math
from collections.abc import Callable

from seoro.bridges.wire import Outcome, RobotMeasurements
from sim_nodes.geometry import Pose2, wrap
from sim_nodes.stateful import Stateful

STEP = 0.01  # [m] between two looks at how close other things are
MOVING = (0.01, 0.05)  # [m/s], [rad/s] from which a robot counts as moving


class Mean(Stateful):
    """A mean over time, and the largest value."""

    STATE = ("_sum", "_count", "_most")

    def __init__(self) -> None:
        self._sum, self._count, self._most = 0.0, 0, 0.0

    def add(self, value: float) -> None:
        """Take in a value."""
        self._sum += value
        self._count += 1
        self._most = max(self._most, value)

    @property
    def mean(self) -> float | None:
        """The mean; None without values."""
        return self._sum / self._count if self._count else None

    @property
    def most(self) -> float | None:
        """The largest value; None without values."""
        return self._most if self._count else None


class Measuring(Stateful):
    """The measurements of one robot, which grow in every tick.

    Args:
        pose: Where it is [m, rad].
        room: How far its outline is from other things at a pose [m].
        interval: Length of a tick [s].
    """

    STATE = (
        "_pose",
        "_tick",
        "_looked_from",
        "_path_length",
        "_driving_ticks",
        "_error",
        "_error_driving",
        "_deviation",
        "_closest",
        "_contacts",
        "_goal",
        "_goals",
    )

    def __init__(self, pose: Pose2, room: Callable[[Pose2], float], interval: float) -> None:
        self._pose = self._looked_from = pose
        self._tick: int | None = None  # of the last look at it
        self._room = room
        self._interval = interval
        self._path_length = 0.0
        self._driving_ticks = 0
        self._error, self._error_driving, self._deviation = Mean(), Mean(), Mean()
        self._closest = room(pose)
        self._contacts = 0
        self._goal: str | None = None  # that it is on its way to
        self._goals = dict.fromkeys(Outcome, 0)

    def passed(self, pose: Pose2, believed: Pose2 | None, deviation: float | None, tick: int) -> None:
        """Take in where the robot is.

        Args:
            pose: In truth.
            believed: By its localisation, if that has a pose.
            deviation: Standard deviation of its position that the localisation itself states [m].
            tick: The present one; a robot that is idle is looked at now and then only.
        """
        way = pose.distance(self._pose.x, self._pose.y)
        turn = abs(wrap(pose.yaw - self._pose.yaw))
        ticks = 1 if self._tick is None else tick - self._tick
        self._tick = tick
        interval = ticks * self._interval
        moving = way > MOVING[0] * interval or turn > MOVING[1] * interval
        self._pose = pose
        if moving:
            self._path_length += way
            self._driving_ticks += ticks
            if pose.distance(self._looked_from.x, self._looked_from.y) >= STEP:
                self._looked_from = pose
                self._closest = min(self._closest, self._room(pose))
        if believed is not None and deviation is not None:
            error = believed.distance(pose.x, pose.y)
            self._error.add(error)
            self._deviation.add(deviation)
            if moving:
                self._error_driving.add(error)

    def touched(self) -> None:
        """Count a contact."""
        self._contacts += 1

    def sent(self, goal: str) -> None:
        """Note that the robot is on its way to a goal, by its id."""
        self._goal = goal

    def ended(self, goal: str, outcome: Outcome) -> None:
        """Count a goal that ended, if the robot was on its way to it: robots have goals of other kinds, too."""
        if goal == self._goal:
            self._goal = None
            self._goals[outcome] += 1

    def result(self, recoveries: int) -> RobotMeasurements:
        """What has been measured so far, with how often the robot has recovered."""
        return RobotMeasurements(
            path_length=self._path_length,
            driving_time=self._driving_ticks * self._interval,
            localisation_error=self._error.mean,
            localisation_error_driving=self._error_driving.mean,
            localisation_error_max=self._error.most,
            localisation_deviation=self._deviation.mean,
            closest_approach=self._closest if math.isfinite(self._closest) else None,
            contacts=self._contacts,
            goals_reached=self._goals[Outcome.SUCCEEDED],
            goals_aborted=self._goals[Outcome.ABORTED],
            goals_canceled=self._goals[Outcome.CANCELED],
            recoveries=recoveries,
        )
