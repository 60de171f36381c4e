"""Driving a robot through poses: plan, follow, recover, arrive or give up.

The phases are those of the behaviour tree that Nav2 ships: follow the plan and plan again when something changes;
when nothing moves, recover by backing up, spinning and waiting in turn, and by forgetting obstacles; then abort.
All times are counted in control cycles of simulated time.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto
from itertools import pairwise
from types import MappingProxyType
from typing import assert_never

import numpy as np

from seoro.bridges.wire import Outcome, Result
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.geometry import Array, Pose2, wrap
from sim_nodes.goals import Ended
from sim_nodes.navigation.controller import LocalController
from sim_nodes.navigation.grid import Grid, NavigationMap
from sim_nodes.navigation.obstacles import ObstacleLayer
from sim_nodes.navigation.planner import ESCAPE_RADIUS, Plan, plan_to
from sim_nodes.robots.declaration import MobileDeclaration
from sim_nodes.robots.diff_drive import AT_REST, Velocity
from sim_nodes.sensors.lidar import Scan
from sim_nodes.stateful import Stateful

GOAL_TOLERANCE = 0.06  # [m], of the localised pose; the localisation's own error comes on top
PASS_TOLERANCE = 0.3  # [m], for poses that are driven through
YAW_TOLERANCE = 0.1  # [rad]
STOPPED = (0.01, 0.02)  # [m/s], [rad/s]
APPROACH_SPEED = 0.03  # [m/s]; a robot that is to stop slows down to it, by 1 m/s per metre
REPLAN_PERIOD = 1.0  # [s]
BLOCKED_TIME = 0.6  # [s] without an open arc before a recovery
PROGRESS_DISTANCE, PROGRESS_TIME = 0.3, 10.0  # [m] that have to be made in [s]
BACK_UP_SPEED = 0.1  # [m/s]
SPIN_RATE = 1.0  # [rad/s]
MIN_MADE = 0.5  # [m] on the way from which on the speed until now says something
SETTLE_TIME = 5.0  # [s] after which a robot that cannot come to rest is taken to be there
MAX_RECOVERIES = 6  # in a row, without progress between them


@dataclass(frozen=True)
class Goal:
    """What a robot is asked to do."""

    id: str
    poses: tuple[Pose2, ...]
    stop_at_each: bool
    feedback_period: float = 0.0  # [s]; 0 for none


@dataclass(frozen=True)
class Situation:
    """What a robot knows in a control cycle."""

    pose: Pose2  # localised, in the map
    velocity: Velocity  # by odometry
    scan: Scan


@dataclass(frozen=True)
class Feedback:
    """How far a robot is on its way, under the names of Nav2's feedback."""

    navigation_time: float  # [s] since the goal was taken up
    distance_remaining: float  # [m] along the plan, and straight from one later pose to the next
    estimated_time_remaining: float  # [s] as fast as until now
    number_of_recoveries: int
    number_of_poses_remaining: int


class Recovery(Enum):
    """What a robot does that cannot go on."""

    BACK_UP = auto()
    SPIN = auto()  # look about, a quarter turn
    WAIT = auto()  # for what is in the way to go on


RECOVERIES = (Recovery.BACK_UP, Recovery.SPIN, Recovery.WAIT)  # one after the other, and again
RECOVERY_TIMES = MappingProxyType({Recovery.BACK_UP: 1.5, Recovery.SPIN: 1.6, Recovery.WAIT: 5.0})  # [s]


class Phase(Enum):
    """What a robot is doing about its goal."""

    FOLLOW = auto()
    ALIGN = auto()
    SETTLE = auto()
    RECOVER = auto()


class Navigator(Stateful):
    """The navigation of one robot.

    Args:
        known: The map.
        obstacles: The obstacle layer, kept up to date by the owner.
        declaration: The robot.
        interval: Length of a control cycle [s].

    Attributes:
        goal: What the robot is on its way to.
        recoveries: How often it has recovered, with all goals.
    """

    STATE = (
        "goal",
        "recoveries",
        "_controller",
        "_index",
        "_tries",
        "_recovered_at",
        "_taken",
        "_recovered_before",
        "_way",
        "_told",
        "_phase",
        "_plan",
        "_planned_for",
        "_cycles",
        "_since_plan",
        "_blocked",
        "_progress_pose",
        "_progress_cycles",
    )

    def __init__(
        self, known: NavigationMap, obstacles: ObstacleLayer, declaration: MobileDeclaration, interval: float
    ) -> None:
        self._map = known
        self._obstacles = obstacles
        self._declaration = declaration
        self._interval = interval
        self._controller = LocalController(known.grid, declaration, interval)
        self.goal: Goal | None = None
        self.recoveries = 0

    def check(self, poses: tuple[Pose2, ...], start: Pose2) -> None:
        """Refuse poses where the robot cannot be, or that cannot be reached on the map.

        Raises:
            RequestRefused: The message says which pose and why.
        """
        numbers = self._number_regions()
        regions = _regions_about(start, numbers, self._map.grid)
        for pose in poses:
            regions = regions & {int(numbers[self._cell_of_goal(pose)])}
            if not regions:
                raise RequestRefused(
                    Result.OPERATION_FAILED,
                    f"goal ({pose.x:.2f}, {pose.y:.2f}) cannot be reached: on the map no way leads there "
                    f"from ({start.x:.2f}, {start.y:.2f})",
                )

    def _number_regions(self) -> Array:
        """Number the connected regions of free floor, for each cell of the map; 0 where the robot cannot be."""
        from scipy.ndimage import label  # noqa: PLC0415 - slow to load, and not needed until a robot navigates

        numbers: Array
        numbers, _ = label(self._map.distance >= self._declaration.clearance, structure=np.ones((3, 3)))
        return numbers

    def _cell_of_goal(self, pose: Pose2) -> tuple[int, int]:
        grid, clearance = self._map.grid, self._declaration.clearance
        where = f"goal ({pose.x:.2f}, {pose.y:.2f})"
        if not grid.contains(pose.x, pose.y):
            right, top = grid.x + grid.columns * grid.resolution, grid.y + grid.rows * grid.resolution
            raise RequestRefused(
                Result.OPERATION_FAILED,
                f"{where} is outside of the map, x {grid.x:.2f} to {right:.2f} and y {grid.y:.2f} to {top:.2f}",
            )
        cell = grid.cell(pose.x, pose.y)
        room = float(self._map.distance[cell])
        if room < clearance:
            place = "inside" if room == 0.0 else f"{room:.2f} m from"
            raise RequestRefused(
                Result.OPERATION_FAILED,
                f"{where} is {place} an obstacle of the map: the robot needs {clearance:.2f} m of clearance",
            )
        return cell

    def start(self, goal: Goal, pose: Pose2) -> None:
        """Take up a goal, from a pose of the robot in the map."""
        self.goal = goal
        self._index = 0
        self._tries = 0  # recoveries in a row
        self._recovered_at = pose
        self._taken = 0  # cycles
        self._recovered_before = self.recoveries
        self._way: float | None = None  # when it was first known [m]
        self._told = 0  # cycle of the last feedback that was due
        self._begin_leg(pose)

    def _begin_leg(self, pose: Pose2) -> None:
        self._phase = Phase.FOLLOW
        self._plan: Plan | None = None
        self._planned_for = -1
        self._cycles = 0  # in this phase
        self._since_plan = 0
        self._blocked = 0
        self._mark_progress(pose)

    def _mark_progress(self, pose: Pose2) -> None:
        self._progress_pose, self._progress_cycles = pose, 0

    def cancel(self) -> Goal | None:
        """Drop the goal; the robot has to be stopped by whoever calls. Returns the goal there was."""
        goal, self.goal = self.goal, None
        self._controller.stop()
        return goal

    def control(self, now: Situation) -> tuple[Velocity, Ended | None]:
        """The velocity of this control cycle, and the end of the goal if it ends. Only with a goal."""
        assert self.goal is not None
        self._cycles += 1
        self._taken += 1
        match self._phase:
            case Phase.FOLLOW:
                return self._follow(now)
            case Phase.ALIGN:
                return self._align(now)
            case Phase.SETTLE:
                return self._settle(now)
            case Phase.RECOVER:
                return self._recover(now)
            case _:
                assert_never(self._phase)

    def feedback_due(self) -> bool:
        """Whether it is time, once in a period, to say how far the robot is."""
        if self.goal is None or self.goal.feedback_period == 0.0:
            return False
        if (self._taken - self._told) * self._interval < self.goal.feedback_period - 1e-9:
            return False
        self._told = self._taken
        return True

    def feedback(self, pose: Pose2) -> Feedback:
        """How far the robot is, from its pose in the map. Only with a goal."""
        assert self.goal is not None
        taken = self._taken * self._interval
        way = self._way_to_go(pose)
        if self._way is None and self._plan is not None:
            self._way = way
        made = (self._way or way) - way
        drive = self._declaration.drive
        speed = min(made / taken, drive.max_speed) if taken > 0.0 and made > MIN_MADE else drive.max_speed
        return Feedback(
            navigation_time=taken,
            distance_remaining=way,
            estimated_time_remaining=way / speed,
            number_of_recoveries=self.recoveries - self._recovered_before,
            number_of_poses_remaining=len(self.goal.poses) - self._index,
        )

    def _way_to_go(self, pose: Pose2) -> float:
        assert self.goal is not None
        poses = self.goal.poses[self._index :]
        later = sum(a.distance(b.x, b.y) for a, b in pairwise(poses))
        if self._plan is None or not self._plan.reaches(pose.x, pose.y):
            return pose.distance(poses[0].x, poses[0].y) + later
        return self._plan.length(pose.x, pose.y) + later

    # ------------------------------------------------------------ follow

    def _follow(self, now: Situation) -> tuple[Velocity, Ended | None]:
        assert self.goal is not None
        target = self.goal.poses[self._index]
        stops = self.goal.stop_at_each or self._index == len(self.goal.poses) - 1
        way = now.pose.distance(target.x, target.y)
        if way < (GOAL_TOLERANCE if stops else PASS_TOLERANCE):
            if stops:
                self._enter(Phase.ALIGN)
                return self._align(now)
            self._next_leg(now.pose)
            return self._controller.velocity, None
        self._replan(now, target)
        if not self._makes_progress(now.pose):
            return self._give_way(now, "made no progress")
        assert self._plan is not None
        if not self._plan.reaches(now.pose.x, now.pose.y):
            return self._hold(now, "found no passage")
        velocity = self._controller.follow(
            self._plan, now.pose, self._obstacles.distance, now.scan, APPROACH_SPEED + way if stops else np.inf
        )
        if velocity is None:
            return self._hold(now, "was blocked")
        self._blocked = 0
        return velocity, None

    def _replan(self, now: Situation, target: Pose2) -> None:
        """Plan if there is something new to plan for: a blocked robot at once, others once a second."""
        self._since_plan += 1
        due = self._since_plan * self._interval >= REPLAN_PERIOD or self._blocked == 1
        lost = self._plan is not None and not self._plan.reaches(now.pose.x, now.pose.y)
        if self._plan is None or (due and (lost or self._planned_for != self._obstacles.changes)):
            self._plan = plan_to(
                self._map.grid,
                self._obstacles.distance,
                self._declaration.clearance,
                (target.x, target.y),
                (now.pose.x, now.pose.y),
            )
            self._planned_for, self._since_plan = self._obstacles.changes, 0

    def _makes_progress(self, pose: Pose2) -> bool:
        self._progress_cycles += 1
        if pose.distance(self._progress_pose.x, self._progress_pose.y) > PROGRESS_DISTANCE:
            self._mark_progress(pose)
            if pose.distance(self._recovered_at.x, self._recovered_at.y) > 2 * PROGRESS_DISTANCE:
                self._tries = 0
        return self._progress_cycles * self._interval < PROGRESS_TIME

    def _hold(self, now: Situation, why: str) -> tuple[Velocity, Ended | None]:
        """Stand still; recover when that has lasted."""
        self._blocked += 1
        if self._blocked * self._interval >= BLOCKED_TIME:
            return self._give_way(now, why)
        return self._controller.stop(), None

    # ------------------------------------------------------------ recover

    def _give_way(self, now: Situation, why: str) -> tuple[Velocity, Ended | None]:
        assert self.goal is not None
        target = self.goal.poses[self._index]
        if self._tries == MAX_RECOVERIES:
            where = f"({target.x:.2f}, {target.y:.2f})"
            message = f"the robot {why} on its way to {where}, also after {MAX_RECOVERIES} recoveries"
            return self._end(Outcome.ABORTED, message)
        self._tries += 1
        self.recoveries += 1
        self._recovered_at = now.pose
        self._enter(Phase.RECOVER)
        return self._recover(now)

    def _recover(self, now: Situation) -> tuple[Velocity, Ended | None]:
        """Carry out the recovery that it is the turn of; from the second on, forget the obstacles after it."""
        kind = RECOVERIES[(self._tries - 1) % len(RECOVERIES)]
        if self._cycles * self._interval >= RECOVERY_TIMES[kind]:
            if self._tries > 1:
                self._obstacles.clear()
            self._begin_leg(now.pose)
            return self._controller.stop(), None
        match kind:
            case Recovery.BACK_UP if speed := self._speed_of_retreat(now.pose):
                return self._controller.steer(Velocity(speed, 0.0)), None
            case Recovery.SPIN:
                return self._controller.steer(Velocity(0.0, SPIN_RATE)), None
            case Recovery.BACK_UP | Recovery.WAIT:
                return self._controller.stop(), None
            case _:
                assert_never(kind)

    def _speed_of_retreat(self, pose: Pose2) -> float:
        """Return the speed [m/s] to back up, or to leave ahead what the robot stands too close to; or 0."""
        clearance, here = self._declaration.clearance, self._room(pose)
        behind, ahead = (self._room(pose.compose(Pose2(way, 0.0, 0.0))) for way in (-0.1, 0.1))
        if behind >= clearance or behind > here:
            return -BACK_UP_SPEED
        return BACK_UP_SPEED if here < clearance and ahead > here else 0.0

    def _room(self, pose: Pose2) -> float:
        return float(self._obstacles.distance[self._map.grid.cell(pose.x, pose.y)])

    # ------------------------------------------------------------ arrive

    def _align(self, now: Situation) -> tuple[Velocity, Ended | None]:
        """Turn to the heading of the goal."""
        assert self.goal is not None
        error = wrap(self.goal.poses[self._index].yaw - now.pose.yaw)
        if abs(error) < YAW_TOLERANCE or self._cycles * self._interval > PROGRESS_TIME:
            self._enter(Phase.SETTLE)
            return self._settle(now)
        rate = max(0.3, min(1.2, 1.5 * abs(error)))
        return self._controller.steer(Velocity(0.0, rate if error > 0 else -rate)), None

    def _settle(self, now: Situation) -> tuple[Velocity, Ended | None]:
        assert self.goal is not None
        v, w = now.velocity
        at_rest = abs(v) < STOPPED[0] and abs(w) < STOPPED[1]
        if not at_rest and self._cycles * self._interval < SETTLE_TIME:
            return self._controller.stop(), None
        if self._index == len(self.goal.poses) - 1:
            return self._end(Outcome.SUCCEEDED, "")
        self._next_leg(now.pose)
        return self._controller.stop(), None

    def _next_leg(self, pose: Pose2) -> None:
        self._index += 1
        self._begin_leg(pose)

    def _enter(self, phase: Phase) -> None:
        self._phase, self._cycles = phase, 0

    def _end(self, outcome: Outcome, message: str) -> tuple[Velocity, Ended]:
        assert self.goal is not None
        ended = Ended(self.goal.id, outcome, message)
        self.goal = None
        self._controller.stop()
        return AT_REST, ended


def _regions_about(start: Pose2, numbers: Array, grid: Grid) -> set[int]:
    """The connected regions of free floor that a robot can get out to."""
    column, row = grid.cell(start.x, start.y)
    if numbers[column, row]:
        return {int(numbers[column, row])}
    reach = round(ESCAPE_RADIUS / grid.resolution)
    near = numbers[max(column - reach, 0) : column + reach + 1, max(row - reach, 0) : row + reach + 1]
    return {int(region) for region in np.unique(near)} - {0}
