"""The motion of an arm: along a trajectory, until it is there, stopped by something, or called off."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from seoro.bridges.wire import Outcome
from sim_nodes.geometry import Array
from sim_nodes.goals import Ended
from sim_nodes.manipulation.trajectory import Moment, Path, Trajectory
from sim_nodes.physics import JointStates
from sim_nodes.stateful import Stateful
from sim_nodes.ticks import TICK

BLOCKED = 0.05  # [rad] behind the trajectory at which something is in the way
BLOCKED_TICKS = 3  # for which a joint has to be that far behind
SETTLE_TIME = 2.0  # [s] after the trajectory's end in which the arm has to come to rest at its goal
AT_REST = 0.01  # [rad/s]
CORRECTION = 0.1  # part of what is left at the end that is added to what motors pull to, in every tick
BRAKE_TIME = 0.2  # [s]


@dataclass(frozen=True)
class Course:
    """What an arm follows.

    `goal` is the id that its client gave it, `tolerance` how near the joints have to come [rad], `points` the
    configurations on the way, shape (k, n) [rad]; the rest each joint's limits [rad/s], [rad/s^2].
    """

    goal: str
    tolerance: float
    points: Array
    max_speed: Array
    max_acceleration: Array

    @cached_property
    def trajectory(self) -> Trajectory:
        """Where the joints are to be when."""
        return Trajectory(Path(self.points), self.max_speed, self.max_acceleration)


class Motion(Stateful):
    """What an arm does with its joints.

    Args:
        joints: Names of the joints.

    Attributes:
        course: What it follows, if anything.
        brakes: Whether it has been called off, and only comes to rest.
    """

    STATE = ("course", "brakes", "_time", "_pace", "_late", "_correction")

    def __init__(self, joints: tuple[str, ...]) -> None:
        self._joints = joints
        self.course: Course | None = None
        self.brakes = False
        self._time = 0.0  # on the trajectory
        self._pace = 1.0
        self._late = 0  # ticks in a row in which a joint was far behind
        # What is added to what motors pull to, since it was needed to come to the last goal [rad].
        self._correction = np.zeros(len(joints))

    @property
    def goal(self) -> str | None:
        """The id of the goal that it is for; None when there is none, or it was called off."""
        return None if self.course is None or self.brakes else self.course.goal

    @property
    def remaining(self) -> float:
        """How long its trajectory goes on [s]."""
        return 0.0 if self.course is None else max(0.0, self.course.trajectory.duration - self._time)

    def follow(self, course: Course) -> None:
        """Begin a motion; one that there is ends where it is."""
        self.course, self.brakes = course, False
        self._time, self._pace, self._late = 0.0, 1.0, 0

    def rename(self, goal: str) -> None:
        """Go on for another goal."""
        if self.course is not None:
            self.course = replace(self.course, goal=goal)

    def brake(self) -> None:
        """Come to rest on the path, within `BRAKE_TIME`."""
        self.brakes = self.course is not None

    def tick(self, states: JointStates) -> tuple[Moment | None, Ended | None]:
        """Go on by a tick.

        Returns:
            What the joints are to do until the next tick, if anything new, and how the goal ended, if it did.
        """
        course = self.course
        if course is None:
            return None, None
        positions, velocities = (values[: len(self._joints)] for values in (states.positions, states.velocities))
        ended = self._end(course, positions, velocities)
        if ended is not None and ended.outcome is Outcome.ABORTED:
            self.course, self._correction = None, np.zeros(len(self._joints))
            return Moment(positions, np.zeros(len(positions))), None if self.brakes else ended
        moment = self._go_on(course)
        is_over = self.brakes and self._pace == 0.0
        if ended is not None or is_over:
            self.course = None
        return moment, None if self.brakes else ended

    def _go_on(self, course: Course) -> Moment:
        if self.brakes:
            self._pace = max(0.0, self._pace - TICK / BRAKE_TIME)
        moment = course.trajectory.at(self._time)
        self._time += self._pace * TICK
        return Moment(moment.positions + self._correction, self._pace * moment.velocities)

    def _end(self, course: Course, positions: Array, velocities: Array) -> Ended | None:
        """How the motion has ended, by where the joints are; None if it goes on."""
        off = course.trajectory.at(self._time).positions - positions
        worst = int(np.argmax(np.abs(off)))
        self._late = self._late + 1 if abs(off[worst]) > BLOCKED else 0
        if self._late >= BLOCKED_TICKS:
            return Ended(course.goal, Outcome.ABORTED, f"{self._joints[worst]} was stopped on its way")
        if self._time < course.trajectory.duration:
            return None
        self._correction = self._correction + CORRECTION * off
        if np.abs(velocities).max() < AT_REST and abs(off[worst]) <= course.tolerance:
            return Ended(course.goal, Outcome.SUCCEEDED)
        if self._time > course.trajectory.duration + SETTLE_TIME:
            left = f"{self._joints[worst]} is {abs(off[worst]):.4f} rad from its goal"
            message = f"{left}, and the tolerance is {course.tolerance:g} rad"
            return Ended(course.goal, Outcome.ABORTED, message)
        return None
