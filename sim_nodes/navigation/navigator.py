"""Navigation of a robot through poses: plan, follow, recover, arrive or abort.

The phases are those of Nav2's default behaviour tree: follow the plan, and replan when something changes. Without
progress, recover by backing up, spinning and waiting in turn, and by clearing obstacles; then abort. All times are
counted in control cycles of simulated time.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto
from itertools import pairwise
from types import MappingProxyType
from typing import assert_never

import numpy as np

from seoro.bridges.wire import Outcome
from sim_nodes.geometry import Array, Pose2, wrap
from sim_nodes.navigation.controller import LocalController
from sim_nodes.navigation.maps import Grid, NavigationMap
from sim_nodes.navigation.obstacles import ObstacleLayer
from sim_nodes.navigation.planner import ESCAPE_RADIUS, Plan, plan_to
from sim_nodes.outcomes import GoalResult, operation_failed
from sim_nodes.robots.declaration import MobileDeclaration
from sim_nodes.robots.kinematics import AT_REST, Velocity
from sim_nodes.sensors.lidar import Scan
from sim_nodes.stateful import Stateful

GOAL_TOLERANCE = 0.06  # [m] of the localised pose; the localisation error is additional
PASS_TOLERANCE = 0.3  # [m] for poses to drive through
YAW_TOLERANCE = 0.1  # [rad]
STOPPED = (0.01, 0.02)  # [m/s], [rad/s]
APPROACH_SPEED = 0.03  # [m/s]; speed at the goal, reduced by 1 m/s per metre before it
REPLAN_PERIOD = 1.0  # [s]
BLOCKED_TIME = 0.6  # [s] without an open arc before a recovery
PROGRESS_DISTANCE, PROGRESS_TIME = 0.3, 10.0  # [m] of progress required within [s]
BACK_UP_SPEED = 0.1  # [m/s]
SPIN_RATE = 1.0  # [rad/s]
MIN_MADE = 0.5  # [m] of progress from which the average speed is meaningful
SETTLE_TIME = 5.0  # [s] after which a robot that does not come to rest counts as arrived
MAX_RECOVERIES = 6  # in a row without progress


@dataclass(frozen=True)
class Goal:
    """A navigation goal."""

    id: str
    poses: tuple[Pose2, ...]
    stop_at_each: bool
    feedback_period: float = 0.0  # [s]; 0 for no feedback


@dataclass(frozen=True)
class ControlInput:
    """Inputs of a control cycle."""

    pose: Pose2  # localised, in `map`
    velocity: Velocity  # by odometry
    scan: Scan


@dataclass(frozen=True)
class Feedback:
    """Progress of a goal, with the names of Nav2's feedback."""

    navigation_time: float  # [s] since the goal was accepted
    distance_remaining: float  # [m] along the plan, then straight between later poses
    estimated_time_remaining: float  # [s] at the average speed
    number_of_recoveries: int
    number_of_poses_remaining: int


class Recovery(Enum):
    """Recovery behaviours of a blocked robot."""

    BACK_UP = auto()
    SPIN = auto()  # a quarter turn, to look around
    WAIT = auto()  # until the obstacle moves on


RECOVERIES = (Recovery.BACK_UP, Recovery.SPIN, Recovery.WAIT)  # in turn
RECOVERY_TIMES = MappingProxyType({Recovery.BACK_UP: 1.5, Recovery.SPIN: 1.6, Recovery.WAIT: 5.0})  # [s]


class Phase(Enum):
    """Phases of a goal."""

    FOLLOW = auto()
    ALIGN = auto()
    SETTLE = auto()
    RECOVER = auto()


class Navigator(Stateful):
    """The navigation of one robot.

    Args:
        known: The map.
        obstacles: The obstacle layer; its owner updates it.
        declaration: Declaration of the robot.
        interval: Length of a control cycle [s].

    Attributes:
        goal: The active goal.
        recoveries: Number of recoveries over all goals.
    """

    STATE = (
        "goal",
        "recoveries",
        "_controller",
        "_index",
        "_attempts",
        "_recovered_at",
        "_elapsed",
        "_recovered_before",
        "_first_distance",
        "_reported_cycle",
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
        """Refuse poses that are invalid or unreachable on the map.

        Raises:
            RequestRefused: The message names the pose and the reason.
        """
        numbers = self._number_regions()
        regions = _regions_about(start, numbers, self._map.grid)
        for pose in poses:
            regions = regions & {int(numbers[self._cell_of_goal(pose)])}
            if not regions:
                raise operation_failed(
                    f"goal ({pose.x:.2f}, {pose.y:.2f}) is unreachable on the map "
                    f"from ({start.x:.2f}, {start.y:.2f})"
                )

    def _number_regions(self) -> Array:
        """Number the connected regions of free floor, for each cell of the map; 0 for closed cells."""
        from scipy.ndimage import label  # noqa: PLC0415 - slow to load, and not needed until a robot navigates

        numbers: Array
        numbers, _ = label(self._map.distance >= self._declaration.clearance, structure=np.ones((3, 3)))
        return numbers

    def _cell_of_goal(self, pose: Pose2) -> tuple[int, int]:
        grid, clearance = self._map.grid, self._declaration.clearance
        where = f"goal ({pose.x:.2f}, {pose.y:.2f})"
        if not grid.contains(pose.x, pose.y):
            right, top = grid.x + grid.columns * grid.resolution, grid.y + grid.rows * grid.resolution
            raise operation_failed(
                f"{where} is outside of the map: x {grid.x:.2f} to {right:.2f} and y {grid.y:.2f} to {top:.2f}"
            )
        cell = grid.cell(pose.x, pose.y)
        room = float(self._map.distance[cell])
        if room < clearance:
            place = "inside" if room == 0.0 else f"{room:.2f} m from"
            raise operation_failed(
                f"{where} is {place} an obstacle of the map; expected a clearance of {clearance:.2f} m or more"
            )
        return cell

    def start(self, goal: Goal, pose: Pose2) -> None:
        """Accept a goal, at a pose of the robot in `map`."""
        self.goal = goal
        self._index = 0
        self._attempts = 0  # recoveries in a row
        self._recovered_at = pose
        self._elapsed = 0  # cycles
        self._recovered_before = self.recoveries
        self._first_distance: float | None = None  # distance at the first plan [m]
        self._reported_cycle = 0  # cycle of the last feedback that was due
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

    def cancel(self) -> None:
        """Drop the goal; the caller must stop the robot."""
        self.goal = None
        self._controller.stop()

    def control(self, now: ControlInput) -> tuple[Velocity, GoalResult | None]:
        """Return the velocity of a control cycle, and the result of the goal if it ends; requires a goal."""
        assert self.goal is not None
        self._cycles += 1
        self._elapsed += 1
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
        """Whether feedback is due, once per period."""
        if self.goal is None or self.goal.feedback_period == 0.0:
            return False
        if (self._elapsed - self._reported_cycle) * self._interval < self.goal.feedback_period - 1e-9:
            return False
        self._reported_cycle = self._elapsed
        return True

    def feedback(self, pose: Pose2) -> Feedback:
        """Return the feedback for a pose of the robot in `map`; requires a goal."""
        assert self.goal is not None
        elapsed = self._elapsed * self._interval
        distance = self._distance_to_go(pose)
        if self._first_distance is None and self._plan is not None:
            self._first_distance = distance
        made = (self._first_distance or distance) - distance
        drive = self._declaration.drive
        speed = min(made / elapsed, drive.max_speed) if elapsed > 0.0 and made > MIN_MADE else drive.max_speed
        return Feedback(
            navigation_time=elapsed,
            distance_remaining=distance,
            estimated_time_remaining=distance / speed,
            number_of_recoveries=self.recoveries - self._recovered_before,
            number_of_poses_remaining=len(self.goal.poses) - self._index,
        )

    def _distance_to_go(self, pose: Pose2) -> float:
        assert self.goal is not None
        poses = self.goal.poses[self._index :]
        later = sum(a.distance(b.x, b.y) for a, b in pairwise(poses))
        if self._plan is None or not self._plan.reaches(pose.x, pose.y):
            return pose.distance(poses[0].x, poses[0].y) + later
        return self._plan.length(pose.x, pose.y) + later

    # ------------------------------------------------------------ follow

    def _follow(self, now: ControlInput) -> tuple[Velocity, GoalResult | None]:
        assert self.goal is not None
        target = self.goal.poses[self._index]
        stops = self.goal.stop_at_each or self._index == len(self.goal.poses) - 1
        distance = now.pose.distance(target.x, target.y)
        if distance < (GOAL_TOLERANCE if stops else PASS_TOLERANCE):
            if stops:
                self._enter(Phase.ALIGN)
                return self._align(now)
            self._next_leg(now.pose)
            return self._controller.velocity, None
        self._replan(now, target)
        if not self._makes_progress(now.pose):
            return self._start_recovery(now, "made no progress")
        assert self._plan is not None
        if not self._plan.reaches(now.pose.x, now.pose.y):
            return self._hold(now, "found no passage")
        velocity = self._controller.follow(
            self._plan,
            now.pose,
            self._obstacles.distance,
            now.scan,
            APPROACH_SPEED + distance if stops else np.inf,
        )
        if velocity is None:
            return self._hold(now, "was blocked")
        self._blocked = 0
        return velocity, None

    def _replan(self, now: ControlInput, target: Pose2) -> None:
        """Plan again if something has changed: immediately if blocked, otherwise once a second."""
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
                self._attempts = 0
        return self._progress_cycles * self._interval < PROGRESS_TIME

    def _hold(self, now: ControlInput, reason: str) -> tuple[Velocity, GoalResult | None]:
        """Stand still; start a recovery if that has lasted."""
        self._blocked += 1
        if self._blocked * self._interval >= BLOCKED_TIME:
            return self._start_recovery(now, reason)
        return self._controller.stop(), None

    # ------------------------------------------------------------ recover

    def _start_recovery(self, now: ControlInput, reason: str) -> tuple[Velocity, GoalResult | None]:
        assert self.goal is not None
        target = self.goal.poses[self._index]
        if self._attempts == MAX_RECOVERIES:
            where = f"({target.x:.2f}, {target.y:.2f})"
            message = f"the robot {reason} on its way to {where}, also after {MAX_RECOVERIES} recoveries"
            return self._end(Outcome.ABORTED, message)
        self._attempts += 1
        self.recoveries += 1
        self._recovered_at = now.pose
        self._enter(Phase.RECOVER)
        return self._recover(now)

    def _recover(self, now: ControlInput) -> tuple[Velocity, GoalResult | None]:
        """Run the present recovery; from the second one on, clear the obstacles afterwards."""
        kind = RECOVERIES[(self._attempts - 1) % len(RECOVERIES)]
        if self._cycles * self._interval >= RECOVERY_TIMES[kind]:
            if self._attempts > 1:
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
        """Return the speed [m/s] to back up, or to leave an obstacle forwards; or 0."""
        clearance, here = self._declaration.clearance, self._room(pose)
        behind, ahead = (self._room(pose.compose(Pose2(distance, 0.0, 0.0))) for distance in (-0.1, 0.1))
        if behind >= clearance or behind > here:
            return -BACK_UP_SPEED
        return BACK_UP_SPEED if here < clearance and ahead > here else 0.0

    def _room(self, pose: Pose2) -> float:
        return float(self._obstacles.distance[self._map.grid.cell(pose.x, pose.y)])

    # ------------------------------------------------------------ arrive

    def _align(self, now: ControlInput) -> tuple[Velocity, GoalResult | None]:
        """Turn to the heading of the goal."""
        assert self.goal is not None
        error = wrap(self.goal.poses[self._index].yaw - now.pose.yaw)
        if abs(error) < YAW_TOLERANCE or self._cycles * self._interval > PROGRESS_TIME:
            self._enter(Phase.SETTLE)
            return self._settle(now)
        rate = max(0.3, min(1.2, 1.5 * abs(error)))
        return self._controller.steer(Velocity(0.0, rate if error > 0 else -rate)), None

    def _settle(self, now: ControlInput) -> tuple[Velocity, GoalResult | None]:
        assert self.goal is not None
        v, w, _ = now.velocity
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

    def _end(self, outcome: Outcome, message: str) -> tuple[Velocity, GoalResult]:
        assert self.goal is not None
        ended = GoalResult(self.goal.id, outcome, message)
        self.goal = None
        self._controller.stop()
        return AT_REST, ended


def _regions_about(start: Pose2, numbers: Array, grid: Grid) -> set[int]:
    """Return the connected regions of free floor that a robot can leave to."""
    column, row = grid.cell(start.x, start.y)
    if numbers[column, row]:
        return {int(numbers[column, row])}
    reach = round(ESCAPE_RADIUS / grid.resolution)
    near = numbers[max(column - reach, 0) : column + reach + 1, max(row - reach, 0) : row + reach + 1]
    return {int(region) for region in np.unique(near)} - {0}
