"""Navigation of a robot through poses: plan, follow, recover, arrive or abort.

The phases are those of Nav2's default behaviour tree: follow the plan, and replan when something changes. Without
progress, recover by backing up, spinning and waiting in turn, and by clearing obstacles; then abort. A robot whose
bumper is pressed backs up at once. All times are counted in decisions of simulated time.
"""

from __future__ import annotations

import math
from enum import Enum, auto
from itertools import pairwise
from typing import assert_never

import numpy as np

from seoro.bridges.wire import Outcome
from sim_nodes.geometry import Pose2, wrap
from sim_nodes.navigation.arrival import has_arrived
from sim_nodes.navigation.contracts import ControlInput, Controller, Following, Path, PlanRequest, Setup
from sim_nodes.navigation.cover import cover_of
from sim_nodes.navigation.goals import Feedback, Goal, check_reachable
from sim_nodes.navigation.maps import NavigationMap
from sim_nodes.navigation.obstacles import ObstacleLayer
from sim_nodes.navigation.plugins import default_plugins, find_controller, find_planner, make_plugin
from sim_nodes.navigation.ramp import Ramp
from sim_nodes.navigation.recoveries import Recoveries
from sim_nodes.navigation.retries import Retries
from sim_nodes.noise import Noise
from sim_nodes.outcomes import GoalResult
from sim_nodes.robots.declaration import MobileDeclaration
from sim_nodes.robots.kinematics import AT_REST, Velocity
from sim_nodes.robots.navigation import PluginDeclaration, Recovery
from sim_nodes.stateful import Stateful
from sim_nodes.ticks import TICK

STOPPED = (0.01, 0.02)  # [m/s], [rad/s]
BLOCKED_TIME = 0.6  # [s] without an open arc before a recovery
OFF_PATH = 0.4  # [m] from the path from which a robot needs another one
REVIEW_TIME = 5.0  # [s] after which a path is planned anew if any obstacle has changed
OBSTACLE_MARGIN = 0.3  # [m] beyond twice the clearance up to which planners know the distance of obstacles
SLACK = 0.03  # [m] that an obstacle may be closer to the path than planned
STRETCH = 1.0  # [m] of the path ahead that obstacles block; farther ones may be gone until the robot is there
MIN_MADE = 0.5  # [m] of progress from which the average speed is meaningful
SETTLE_TIME = 5.0  # [s] after which a robot that does not come to rest counts as arrived
ALIGN_TIME = 10.0  # [s] after which a robot that does not reach its heading counts as arrived
ALIGN_GAIN = 1.5  # [1/s]
ALIGN_RATES = (0.3, 1.2)  # minimum and maximum [rad/s]


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
        noise: Source of random numbers for plugins.

    Attributes:
        goal: The active goal.
        recoveries: Number of recoveries over all goals.
        period: Ticks between decisions.
    """

    STATE = (
        "goal",
        "recoveries",
        "_planner",
        "_controller",
        "_ramp",
        "_index",
        "_retries",
        "_elapsed",
        "_recovered_before",
        "_first_distance",
        "_reported_cycle",
        "_recovery",
        "_phase",
        "_path",
        "_planned_for",
        "_cycles",
        "_since_plan",
        "_blocked",
        "_progress_pose",
        "_progress_cycles",
    )

    def __init__(
        self, known: NavigationMap, obstacles: ObstacleLayer, declaration: MobileDeclaration, noise: Noise
    ) -> None:
        self._map = known
        self._obstacles = obstacles
        self._declaration = declaration
        self._parameters = p = declaration.navigation
        self.period = max(1, round(1.0 / p.controller_frequency / TICK))
        self._interval = self.period * TICK
        self._obstacle_reach = max(p.inflation_radius, 2.0 * declaration.clearance + OBSTACLE_MARGIN)
        self._patience = math.ceil(BLOCKED_TIME / self._interval)  # decisions without an open arc

        def setup(plugin: PluginDeclaration) -> Setup:
            return Setup(declaration, known, plugin.parameters, noise)

        self._cover = cover_of(declaration)
        planner, controller = default_plugins(declaration)
        self._planner = make_plugin(find_planner(planner.plugin), planner.plugin, setup(planner))
        self._controller = make_plugin(find_controller(controller.plugin), controller.plugin, setup(controller))
        self._recoveries = Recoveries(known, declaration, self._cover)
        self._retries = Retries(2.0 * p.required_movement_radius)
        self._ramp = Ramp(declaration.drive)
        radius = declaration.drive.min_turning_radius
        self._can_align = not radius
        self._no_headings = f"the planner {planner.plugin!r} returned a path without headings; cars need headings"
        self._no_passage = "found no passage" + (f" for a turning radius of {radius:.2f} m" if radius else "")
        self.goal: Goal | None = None
        self.recoveries = 0

    def check(self, poses: tuple[Pose2, ...], start: Pose2) -> None:
        """Refuse poses that are invalid or unreachable on the map.

        Raises:
            RequestRefused: See `check_reachable`.
        """
        check_reachable(poses, start, self._map, self._cover)

    def start(self, goal: Goal, pose: Pose2) -> None:
        """Accept a goal, at a pose of the robot in `map`."""
        self.goal = goal
        self._index = 0
        self._retries.begin(pose)
        self._elapsed = 0  # decisions
        self._recovered_before = self.recoveries
        self._first_distance: float | None = None  # distance at the first plan [m]
        self._reported_cycle = 0  # decision of the last feedback that was due
        self._recovery: Recovery | None = None
        self._begin_leg(pose)

    def _begin_leg(self, pose: Pose2) -> None:
        self._phase = Phase.FOLLOW
        self._path: Path | None = None
        self._planned_for: int | None = None  # changes of obstacles
        self._cycles = 0  # decisions in this phase
        self._since_plan = 0
        self._blocked = 0
        self._controller.begin()
        self._mark_progress(pose)

    def _mark_progress(self, pose: Pose2) -> None:
        self._progress_pose, self._progress_cycles = pose, 0

    def cancel(self) -> None:
        """Drop the goal; the caller must stop the robot."""
        self.goal = None
        self._ramp.stop()

    def decide(self, now: ControlInput) -> GoalResult | Following[Controller] | None:
        """Decide on the velocity from now on; requires a goal.

        Returns:
            The result of the goal if it ends, or a call of the controller, whose result `drive` accepts.
        """
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

    def velocity(self) -> Velocity:
        """Return the velocity from this tick on; call it once in each tick."""
        return self._ramp.follow()

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
        if self._first_distance is None and self._path is not None:
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
        if self._path is None:
            return pose.distance(poses[0].x, poses[0].y) + later
        return self._path.length(pose.x, pose.y) + later

    # ------------------------------------------------------------ follow

    def _follow(self, now: ControlInput) -> GoalResult | Following[Controller] | None:
        assert self.goal is not None
        target = self.goal.poses[self._index]
        stops = self.goal.stop_at_each or self._index == len(self.goal.poses) - 1
        if self._is_there(now.pose, target, stops=stops):
            if stops:
                self._enter(Phase.ALIGN)
                return self._align(now)
            self._next_leg(now.pose)
        if now.touched:
            return self._start_recovery(now, "touched something", "backup")
        target = self.goal.poses[self._index]
        self._replan(now, target)
        if not self._makes_progress(now.pose):
            return self._start_recovery(now, "made no progress")
        if self._path is None:
            return self._hold(now, self._no_passage)
        if self._path.headings is None and not self._can_align:
            return self._end(Outcome.ABORTED, self._no_headings)
        return Following(self._controller, self._path, now, stops)

    def drive(self, now: ControlInput, velocity: Velocity | None) -> GoalResult | None:
        """Accept the velocity of the controller, None if it is blocked; returns the result if the goal ends."""
        if velocity is None:
            return self._hold(now, "was blocked")
        self._blocked = 0
        self._ramp.wanted = velocity
        return None

    def _is_there(self, pose: Pose2, target: Pose2, *, stops: bool) -> bool:
        if not stops:
            return pose.distance(target.x, target.y) < self._parameters.passed_goal_radius
        follows = self._controller.FOLLOWS_HEADINGS
        if self._path is None:
            aligns = self._can_align and self._cover.is_round
        else:
            aligns = self._can_align and not (follows and self._path.headings is not None)
        return has_arrived(self._declaration, pose, target, self._path, aligns=aligns, follows=follows)

    def _replan(self, now: ControlInput, target: Pose2) -> None:
        """Plan again if that is needed: at once if blocked, otherwise at the rate of the planner."""
        self._since_plan += 1
        since = self._since_plan * self._interval
        # Obstacles that block the robot are on the map of obstacles when it gives up waiting.
        is_blocked = self._blocked in (1, self._patience - 1)
        due = is_blocked or since >= 1.0 / self._parameters.expected_planner_frequency
        if self._planned_for is not None and not (due and self._needs_plan(now, since)):
            return
        distance = self._obstacles.distance(self._obstacle_reach)
        distance.setflags(write=False)
        self._path = self._planner.plan(PlanRequest(self._map.grid, distance, now.pose, target, now.tick))
        if self._path is not None:
            self._controller.set_plan(self._path)
        self._planned_for, self._since_plan = self._obstacles.changes, 0

    def _needs_plan(self, now: ControlInput, since: float) -> bool:
        """Whether the path is missing or blocked, the robot has left it, or it was planned long ago."""
        has_changed = self._planned_for != self._obstacles.changes
        if self._path is None:
            return has_changed
        index = self._path.nearest(now.pose.x, now.pose.y)
        if np.hypot(*(self._path.points[index] - now.pose[:2])) > OFF_PATH or self._blocked:
            return True
        review = since >= REVIEW_TIME and self._path.headings is None  # plans over poses cost more
        return has_changed and (review or self._is_obstructed(self._path, index))

    def _is_obstructed(self, path: Path, index: int) -> bool:
        """Whether an obstacle is too close to the stretch of the path from a point on."""
        obstacles = self._obstacles.points
        if len(obstacles) == 0:
            return False
        ahead = slice(index, int(np.searchsorted(path.gone, path.gone[index] + STRETCH)) + 1, 2)
        if path.headings is not None:
            gaps = self._cover.gaps_to(obstacles[:, 0], obstacles[:, 1], path.poses[ahead])
            return float(gaps.min()) < -SLACK
        points = path.points[ahead]
        dx, dy = obstacles[:, :1] - points[:, 0], obstacles[:, 1:] - points[:, 1]
        closest = math.sqrt(float((dx * dx + dy * dy).min()))  # `hypot` of all pairs takes five times as long
        return closest < self._declaration.clearance - SLACK

    def _makes_progress(self, pose: Pose2) -> bool:
        p = self._parameters
        self._progress_cycles += 1
        if pose.distance(self._progress_pose.x, self._progress_pose.y) > p.required_movement_radius:
            self._mark_progress(pose)
            self._retries.move_on(pose)
        return self._progress_cycles * self._interval < p.movement_time_allowance

    def _hold(self, now: ControlInput, reason: str) -> GoalResult | None:
        """Stand still; start a recovery if that has lasted."""
        self._blocked += 1
        if self._blocked >= self._patience:
            return self._start_recovery(now, reason)
        self._ramp.stop()
        return None

    # ------------------------------------------------------------ recover

    def _start_recovery(self, now: ControlInput, reason: str, kind: Recovery | None = None) -> GoalResult | None:
        """Start the next recovery, or one of a kind; abort after too many."""
        assert self.goal is not None
        p = self._parameters
        target = self.goal.poses[self._index]
        kinds = self._recoveries.kinds
        most = p.number_of_retries if kinds else 0
        if self._retries.without_progress >= most:
            after = f", also after {self.recoveries - self._recovered_before} recoveries" if most else ""
            message = f"the robot {reason} on its way to ({target.x:.2f}, {target.y:.2f}){after}"
            return self._end(Outcome.ABORTED, message)
        self._recovery = kind or kinds[self._retries.in_a_row % len(kinds)]
        self._retries.add(now.pose)
        self.recoveries += 1
        self._ramp.stop()
        self._enter(Phase.RECOVER)
        return self._recover(now)

    def _recover(self, now: ControlInput) -> GoalResult | None:
        """Run the present recovery; from the second one on, clear the obstacles afterwards."""
        assert self._recovery is not None
        if self._cycles * self._interval >= self._recoveries.duration(self._recovery):
            if self._retries.in_a_row > 1:
                self._obstacles.clear()
            self._begin_leg(now.pose)
            self._ramp.stop()
            return None
        self._ramp.wanted = self._recoveries.velocity(self._recovery, now)
        return None

    # ------------------------------------------------------------ arrive

    def _align(self, now: ControlInput) -> GoalResult | None:
        """Turn to the heading of the goal."""
        assert self.goal is not None
        error = wrap(self.goal.poses[self._index].yaw - now.pose.yaw)
        if abs(error) < self._parameters.yaw_goal_tolerance or self._cycles * self._interval > ALIGN_TIME:
            self._enter(Phase.SETTLE)
            return self._settle(now)
        low, high = ALIGN_RATES
        rate = max(low, min(high, ALIGN_GAIN * abs(error)))
        turn = math.copysign(rate, error)
        self._ramp.wanted = Velocity(0.0, turn) if self._recoveries.can_turn(now, turn) else AT_REST
        return None

    def _settle(self, now: ControlInput) -> GoalResult | None:
        assert self.goal is not None
        self._ramp.stop()
        v, w, u = now.velocity
        at_rest = math.hypot(v, u) < STOPPED[0] and abs(w) < STOPPED[1]
        if not at_rest and self._cycles * self._interval < SETTLE_TIME:
            return None
        if self._index == len(self.goal.poses) - 1:
            return self._end(Outcome.SUCCEEDED, "")
        self._next_leg(now.pose)
        return None

    def _next_leg(self, pose: Pose2) -> None:
        self._index += 1
        self._retries.begin_leg()
        self._begin_leg(pose)

    def _enter(self, phase: Phase) -> None:
        self._phase, self._cycles = phase, 0

    def _end(self, outcome: Outcome, message: str) -> GoalResult:
        assert self.goal is not None
        ended = GoalResult(self.goal.id, outcome, message)
        self.goal = None
        self._ramp.stop()
        return ended
