"""Measurements of robots and entities, updated while a run goes on."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import field, replace

from seoro.bridges.wire import EntityMeasurements, Outcome, RobotMeasurements
from seoro.deferred import dataclass
from sim_nodes.clearance import Clearance
from sim_nodes.geometry import Pose2, Vector, wrap
from sim_nodes.navigation.goals import Goal
from sim_nodes.stateful import Stateful
from sim_nodes.ticks import TICK

STEP = 0.01  # [m] between two computations of the clearance
MOVING = (0.01, 0.05)  # [m/s], [rad/s] from which a robot is moving
MAX_DRIVES = 1000  # ended goals of the path efficiency; later ones do not count


class Mean(Stateful):
    """A mean over time, and the maximum."""

    STATE = ("_sum", "_count", "_maximum")

    def __init__(self) -> None:
        self._sum, self._count, self._maximum = 0.0, 0, 0.0

    def add(self, value: float) -> None:
        """Add a value."""
        self._sum += value
        self._count += 1
        self._maximum = max(self._maximum, value)

    @property
    def mean(self) -> float | None:
        """Mean value; None without values."""
        return self._sum / self._count if self._count else None

    @property
    def maximum(self) -> float | None:
        """Maximum value; None without values."""
        return self._maximum if self._count else None


class Smoothness(Stateful):
    """Log dimensionless jerk of a speed that is sampled in ticks of motion.

    The formula is -ln(T^3 / v^2 * integral of (d2v/dt2)^2 dt), with the time of motion T and the greatest speed v
    (Balasubramanian et al. 2015, On the analysis of movement smoothness, equation 4).
    """

    STATE = ("_last", "_squares", "_ticks", "_peak")

    def __init__(self) -> None:
        self._last: tuple[float, ...] = ()  # at most two speeds of ticks in a row [m/s]
        self._squares = 0.0  # sum of squares of the second difference of the speed [m^2/s^2]
        self._ticks = 0
        self._peak = 0.0

    def add(self, speed: float) -> None:
        """Add the speed of a tick that follows the one before [m/s]."""
        last = self._last
        if len(last) == 2:
            self._squares += (speed - 2.0 * last[1] + last[0]) ** 2
        self._last = (*last[-1:], speed)
        self._ticks += 1
        self._peak = max(self._peak, speed)

    def interrupt(self) -> None:
        """Start a new series: the next speed does not follow the last one."""
        self._last = ()

    @property
    def value(self) -> float | None:
        """Log dimensionless jerk; None without motion or jerk."""
        if self._squares == 0.0 or self._peak == 0.0:
            return None
        duration = self._ticks * TICK
        return -math.log(duration**3 / self._peak**2 * self._squares / TICK**3)


@dataclass(frozen=True)
class EndedDrive:
    """A navigation goal that has ended: its poses, length of the driven path [m], and success."""

    start: Pose2
    poses: tuple[Pose2, ...]
    length: float
    succeeded: bool


@dataclass(frozen=True)
class Rooms:
    """Named rooms of a world: lower and upper corners [m]."""

    corners: Mapping[str, tuple[Vector, Vector]]

    def at(self, x: float, y: float) -> list[str]:
        """Return the names of the rooms that contain a point, from above."""
        return [
            name
            for name, (lower, upper) in self.corners.items()
            if lower[0] <= x <= upper[0] and lower[1] <= y <= upper[1]
        ]


class Stays(Stateful):
    """Ticks in each room.

    Args:
        rooms: The rooms.
    """

    STATE = ("_ticks",)

    def __init__(self, rooms: Rooms) -> None:
        self._rooms = rooms
        self._ticks = dict.fromkeys(rooms.corners, 0)

    def add(self, x: float, y: float, ticks: int) -> None:
        """Add ticks at a point."""
        if self._ticks:
            for name in self._rooms.at(x, y):
                self._ticks[name] += ticks

    def times(self) -> dict[str, float]:
        """Return the time in each room [s]."""
        return {name: ticks * TICK for name, ticks in self._ticks.items()}


class RobotMetrics(Stateful):
    """The measurements of one robot, updated in every tick.

    Args:
        pose: Initial pose [m, rad].
        closest: The nearest entity there.
        rooms: Rooms of the world.
        lever: Radius of a footprint [m], whose corners move in turns; 0 for a circle.
    """

    STATE = (
        "_pose",
        "_tick",
        "_measured_at",
        "_path_length",
        "_driving_ticks",
        "_error",
        "_error_driving",
        "_deviation",
        "_speed",
        "_smoothness",
        "_stays",
        "_closest",
        "_contacts",
        "_goal",
        "_began",
        "_drives",
        "_goals",
    )

    def __init__(self, pose: Pose2, closest: Clearance, rooms: Rooms, lever: float = 0.0) -> None:
        self._pose = self._measured_at = pose
        self._lever = lever
        self._tick: int | None = None  # of the last update
        self._path_length = 0.0
        self._driving_ticks = 0
        self._error, self._error_driving, self._deviation, self._speed = Mean(), Mean(), Mean(), Mean()
        self._smoothness = Smoothness()
        self._stays = Stays(rooms)
        self._closest = closest
        self._contacts: dict[str, int] = {}
        self._goal: Goal | None = None  # navigation goal
        self._began: tuple[Pose2, float] = (pose, 0.0)  # pose and path length at its start
        self._drives: list[EndedDrive] = []
        self._goals = dict.fromkeys(Outcome, 0)

    def update(
        self,
        pose: Pose2,
        speed: float,
        believed: Pose2 | None,
        deviation: float | None,
        tick: int,
    ) -> float | None:
        """Update with the pose of the robot.

        Returns:
            Distance up to which the nearest entity is wanted by `approach` [m]; None if it is not.

        Args:
            pose: True pose.
            speed: True speed in the plane [m/s].
            believed: Localised pose; None before localisation.
            deviation: Standard deviation of the position by the localisation [m].
            tick: Present tick; idle robots are updated less often.
        """
        x, y, yaw = pose
        last_x, last_y, last_yaw = self._pose
        way = math.hypot(x - last_x, y - last_y)
        turn = abs(wrap(yaw - last_yaw))
        ticks = 1 if self._tick is None else tick - self._tick
        self._tick = tick
        interval = ticks * TICK
        moving = way > MOVING[0] * interval or turn > MOVING[1] * interval
        within = None
        self._pose = pose
        self._stays.add(x, y, ticks)
        if not moving or ticks != 1:
            self._smoothness.interrupt()
        if moving:
            self._path_length += way
            self._driving_ticks += ticks
            self._speed.add(speed)
            self._smoothness.add(speed)
            last_x, last_y, last_yaw = self._measured_at
            if math.hypot(x - last_x, y - last_y) + self._lever * abs(wrap(yaw - last_yaw)) >= STEP:
                self._measured_at = pose
                within = self._closest.distance
        if believed is not None and deviation is not None:
            error = math.hypot(believed.x - x, believed.y - y)
            self._error.add(error)
            self._deviation.add(deviation)
            if moving:
                self._error_driving.add(error)
        return within

    def approach(self, nearest: Clearance) -> None:
        """Update with the nearest entity."""
        if nearest.distance < self._closest.distance:
            self._closest = nearest

    def count_contact(self, other: str) -> None:
        """Count a contact with another entity."""
        self._contacts[other] = self._contacts.get(other, 0) + 1

    def start_goal(self, goal: Goal) -> None:
        """Start a navigation goal."""
        self._goal = goal
        self._began = (self._pose, self._path_length)

    def end_goal(self, goal: str, outcome: Outcome) -> None:
        """Count the result of a goal if it is the navigation goal; robots have goals of other kinds, too."""
        if self._goal is None or goal != self._goal.id:
            return
        start, length = self._began
        if outcome is not Outcome.CANCELED and len(self._drives) < MAX_DRIVES:
            drive = EndedDrive(start, self._goal.poses, self._path_length - length, outcome is Outcome.SUCCEEDED)
            self._drives.append(drive)
        self._goal = None
        self._goals[outcome] += 1

    @property
    def drives(self) -> tuple[EndedDrive, ...]:
        """Goals that were reached or aborted, at most `MAX_DRIVES`."""
        return tuple(self._drives)

    def result(
        self,
        recoveries: int,
        work: float | None = None,
        energy: float | None = None,
        efficiency: float | None = None,
    ) -> RobotMeasurements:
        """Return the measurements so far.

        Args:
            recoveries: Number of recoveries.
            work: Mechanical work of its motors [J]; None if the engine does not know it.
            energy: Energy drawn from the battery [J].
            efficiency: Success weighted by path length.
        """
        closest = self._closest
        return RobotMeasurements(
            path_length=self._path_length,
            driving_time=self._driving_ticks * TICK,
            localisation_error=self._error.mean,
            localisation_error_driving=self._error_driving.mean,
            localisation_error_max=self._error.maximum,
            localisation_deviation=self._deviation.mean,
            closest_approach=closest.distance if math.isfinite(closest.distance) else None,
            contacts=sum(self._contacts.values()),
            goals_reached=self._goals[Outcome.SUCCEEDED],
            goals_aborted=self._goals[Outcome.ABORTED],
            goals_canceled=self._goals[Outcome.CANCELED],
            recoveries=recoveries,
            closest_entity=closest.entity,
            max_speed=self._speed.maximum or 0.0,
            mean_speed=self._speed.mean,
            contacts_with=dict(self._contacts),
            time_in=self._stays.times(),
            energy=energy,
            smoothness=self._smoothness.value,
            path_efficiency=efficiency,
            work=work,
        )


@dataclass(frozen=True)
class EntityMetrics:
    """The measurements of a movable entity up to a tick."""

    tick: int
    seen: Vector  # position in that tick [m]
    turned: Vector  # last point of the path [m]
    path_length: float = 0.0
    max_speed: float = 0.0
    contacts: Mapping[str, int] = field(default_factory=dict)
    ticks_in: Mapping[str, int] = field(default_factory=dict)  # by room

    def updated(self, position: Vector, speed: float, tick: int, rooms: Rooms) -> EntityMetrics:
        """Return the measurements with the position [m] and speed [m/s] in a tick."""
        ticks = tick - self.tick
        if ticks <= 0:
            return self
        passed = math.dist(position[:2], self.seen[:2]) / (ticks * TICK)
        way = math.dist(position[:2], self.turned[:2])
        moves = way > MOVING[0] * ticks * TICK
        inside = {name: self.ticks_in.get(name, 0) + ticks for name in rooms.at(position[0], position[1])}
        return replace(
            self,
            tick=tick,
            seen=position,
            turned=position if moves else self.turned,
            path_length=self.path_length + way if moves else self.path_length,
            max_speed=max(self.max_speed, speed, passed),
            ticks_in={**self.ticks_in, **inside},
        )

    def touched(self, other: str) -> EntityMetrics:
        """Return the measurements with another contact."""
        return replace(self, contacts={**self.contacts, other: self.contacts.get(other, 0) + 1})

    def result(self, rooms: Rooms) -> EntityMeasurements:
        """Return the message with the measurements."""
        return EntityMeasurements(
            path_length=self.path_length,
            max_speed=self.max_speed,
            contacts=sum(self.contacts.values()),
            contacts_with=dict(self.contacts),
            time_in={name: self.ticks_in.get(name, 0) * TICK for name in rooms.corners},
        )
