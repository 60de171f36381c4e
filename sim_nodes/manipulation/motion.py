"""Joint paths, trajectories along them, and their execution by an arm.

A path is a curve through configurations. A trajectory is a path with a quintic time scaling, whose speed and
acceleration are zero at both ends. With fewer than three configurations, the path is a straight line. Otherwise it
is a monotone cubic of each joint, which stays between neighbouring values, so that limits that hold at the
configurations also hold between them. A motion ends when the arm arrives, is blocked, or is cancelled.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from seoro.bridges.wire import Outcome
from seoro.deferred import dataclass
from sim_nodes.geometry import Array
from sim_nodes.outcomes import GoalResult
from sim_nodes.physics import JointStates
from sim_nodes.stateful import Stateful
from sim_nodes.ticks import TICK

SAMPLES = 200  # points of a path at which speeds and accelerations are compared with limits
SHORTEST = 0.04  # [s], also for a path without length


class TrajectoryPoint(NamedTuple):
    """Positions and velocities of the joints at a time, each of shape (n,)."""

    positions: Array  # [rad], [m]
    velocities: Array  # [rad/s], [m/s]


class Path:
    """A curve through configurations, parametrized from 0 to 1 in proportion to the motion of the joints.

    Args:
        configurations: At least two; neighbouring ones differ.

    Attributes:
        points: The configurations, shape (k, n).
        knots: Their path parameters, shape (k,).
    """

    def __init__(self, configurations: Sequence[Array] | Array) -> None:
        self.points: Array = np.array(configurations)
        points = self.points
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        self.knots: Array = np.concatenate([[0.0], np.cumsum(steps)]) / max(float(steps.sum()), 1e-12)
        if len(points) > 2:
            from scipy.interpolate import PchipInterpolator  # noqa: PLC0415 - slow to load, and seldom needed

            self._curve = PchipInterpolator(self.knots, points)
        else:
            self._curve = None
        self._start, self._way = points[0], points[-1] - points[0]

    def at(self, place: float) -> Array:
        """Return the configuration at a path parameter."""
        return self._start + place * self._way if self._curve is None else np.asarray(self._curve(place))

    def derivatives(self, places: Array) -> tuple[Array, Array]:
        """Return the first and second derivative by the parameter, each of shape (len(places), n)."""
        if self._curve is None:
            return np.tile(self._way, (len(places), 1)), np.zeros((len(places), len(self._way)))
        return np.asarray(self._curve(places, 1)), np.asarray(self._curve(places, 2))


class Trajectory:
    """A path in time, as fast as the limits allow.

    Args:
        path: The path.
        max_speed: Limit of each joint [rad/s], [m/s].
        max_acceleration: Limit of each joint [rad/s^2], [m/s^2].
    """

    def __init__(self, path: Path, max_speed: Array, max_acceleration: Array) -> None:
        self.path = path
        times = np.linspace(0.0, 1.0, SAMPLES)
        place, rate, change = _scaling(times)
        first, second = path.derivatives(place)
        # For a duration T, speeds scale with 1 / T and accelerations with 1 / T^2.
        speed = np.abs(first * rate[:, None]) / max_speed
        acceleration = np.abs(second * rate[:, None] ** 2 + first * change[:, None]) / max_acceleration
        self.duration = max(SHORTEST, float(speed.max()), float(np.sqrt(acceleration.max())))  # [s]

    def at(self, time: float) -> TrajectoryPoint:
        """Return the target at a time since the start [s]; at rest before and after."""
        unit = np.array([min(max(time / self.duration, 0.0), 1.0)])
        place, rate, _ = _scaling(unit)
        first, _ = self.path.derivatives(place)
        return TrajectoryPoint(self.path.at(float(place[0])), first[0] * rate[0] / self.duration)


def _scaling(time: Array) -> tuple[Array, Array, Array]:
    """Return the path parameter at times from 0 to 1, and its first and second derivative by time."""
    place = time**3 * (10.0 - 15.0 * time + 6.0 * time**2)
    rate = 30.0 * time**2 * (1.0 - time) ** 2
    change = 60.0 * time * (1.0 - time) * (1.0 - 2.0 * time)
    return place, rate, change


BLOCKED = 0.05  # [rad], [m] lag behind the trajectory that indicates an obstacle
YIELDING = 0.3  # [rad], [m] that lag for joints that carry the weight of their body
BLOCKED_TICKS = 3  # of that lag in a row
SETTLE_TIME = 2.0  # [s] after the end of the trajectory for the arm to come to rest
AT_REST = 0.01  # [rad/s], [m/s]
CORRECTION = 0.1  # share of the remaining error that is added to the motor targets in each tick
BRAKE_TIME = 0.2  # [s]


@dataclass(frozen=True)
class JointMotion:
    """A trajectory to follow.

    `goal` is the id given by the client, `tolerance` the maximum error of each joint, `points` the waypoints,
    shape (k, n). `max_speed` and `max_acceleration` are limits of each joint. Units are rad or m, and s.
    """

    goal: str
    tolerance: float
    points: Array
    max_speed: Array
    max_acceleration: Array

    @cached_property
    def trajectory(self) -> Trajectory:
        """Positions of the joints over time."""
        return Trajectory(Path(self.points), self.max_speed, self.max_acceleration)


class Motion(Stateful):
    """Execution of trajectories by the joints of an arm.

    Args:
        joints: Names of the joints.
        units: Units of their positions.
        stands: Whether the joints carry the weight of their body, which may sway.

    Attributes:
        course: The trajectory, if any.
        is_braking: Whether the motion was cancelled and only comes to rest.
    """

    STATE = ("course", "is_braking", "_time", "_pace", "_late", "_correction")

    def __init__(self, joints: tuple[str, ...], units: tuple[str, ...], *, stands: bool = False) -> None:
        self._joints, self._units, self._stands = joints, units, stands
        self._blocked = YIELDING if stands else BLOCKED
        self.course: JointMotion | None = None
        self.is_braking = False
        self._time = 0.0  # on the trajectory
        self._pace = 1.0
        self._late = 0  # ticks in a row with a joint far behind
        # Offset of the motor targets that was needed to reach the last goal [rad], [m].
        self._correction = np.zeros(len(joints))

    @property
    def goal(self) -> str | None:
        """Id of the active goal; None without one, or after its cancellation."""
        return None if self.course is None or self.is_braking else self.course.goal

    @property
    def remaining(self) -> float:
        """Remaining time of the trajectory [s]."""
        return 0.0 if self.course is None else max(0.0, self.course.trajectory.duration - self._time)

    def follow(self, course: JointMotion) -> None:
        """Start a trajectory; a present one ends where it is."""
        self.course, self.is_braking = course, False
        self._time, self._pace, self._late = 0.0, 1.0, 0

    def rename(self, goal: str) -> None:
        """Continue for another goal."""
        if self.course is not None:
            self.course = replace(self.course, goal=goal)

    def brake(self) -> None:
        """Come to rest on the path within `BRAKE_TIME`."""
        self.is_braking = self.course is not None

    def tick(self, states: JointStates) -> tuple[TrajectoryPoint | None, GoalResult | None]:
        """Update with a tick.

        Returns:
            Next targets of the joints, if they change, and the result of the goal, if it ended.
        """
        course = self.course
        if course is None:
            return None, None
        positions, velocities = (values[: len(self._joints)] for values in (states.positions, states.velocities))
        ended = self._end(course, positions, velocities)
        if ended is not None and ended.outcome is Outcome.ABORTED:
            self.course, self._correction = None, np.zeros(len(self._joints))
            return TrajectoryPoint(positions, np.zeros(len(positions))), None if self.is_braking else ended
        moment = self._advance(course)
        is_over = self.is_braking and self._pace == 0.0
        if ended is not None or is_over:
            self.course = None
        return moment, None if self.is_braking else ended

    def _advance(self, course: JointMotion) -> TrajectoryPoint:
        if self.is_braking:
            self._pace = max(0.0, self._pace - TICK / BRAKE_TIME)
        moment = course.trajectory.at(self._time)
        self._time += self._pace * TICK
        return TrajectoryPoint(moment.positions + self._correction, self._pace * moment.velocities)

    def _end(self, course: JointMotion, positions: Array, velocities: Array) -> GoalResult | None:
        """Return the result of the motion by the state of the joints; None while it continues."""
        off = course.trajectory.at(self._time).positions - positions
        worst = int(np.argmax(np.abs(off)))
        self._late = self._late + 1 if abs(off[worst]) > self._blocked else 0
        if self._late >= BLOCKED_TICKS:
            return GoalResult(course.goal, Outcome.ABORTED, f"{self._joints[worst]} was blocked")
        if self._time < course.trajectory.duration:
            return None
        self._correction = self._correction + CORRECTION * off
        if np.abs(velocities).max() < AT_REST and abs(off[worst]) <= course.tolerance:
            return GoalResult(course.goal, Outcome.SUCCEEDED)
        if self._time > course.trajectory.duration + SETTLE_TIME:
            if self._stands and abs(off[worst]) <= course.tolerance:
                return GoalResult(course.goal, Outcome.SUCCEEDED)
            unit = self._units[worst]
            left = f"{self._joints[worst]} is {abs(off[worst]):.4f} {unit} from its goal"
            message = f"{left}, with a tolerance of {course.tolerance:g} {unit}"
            return GoalResult(course.goal, Outcome.ABORTED, message)
        return None
