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

from seoro.bridges.wire import Outcome
from sim_nodes.geometry import Pose2, wrap
from sim_nodes.navigation.arrival import align_rate, has_arrived
from sim_nodes.navigation.contracts import ControlInput, Controller, Following, Path, Setup
from sim_nodes.navigation.cover import cover_of
from sim_nodes.navigation.goals import Feedback, Goal, check_reachable
from sim_nodes.navigation.maps import NavigationMap
from sim_nodes.navigation.obstacles import ObstacleLayer
from sim_nodes.navigation.plugins import default_plugins, find_controller, find_planner, make_plugin
from sim_nodes.navigation.ramp import Ramp
from sim_nodes.navigation.recoveries import Recoveries
from sim_nodes.navigation.replanning import Replanning
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
MIN_MADE = 0.5  # [m] of progress from which the average speed is meaningful
SETTLE_TIME = 5.0  # [s] after which a robot that does not come to rest counts as arrived
ALIGN_TIME = 10.0  # [s] after which a robot that does not reach its heading counts as arrived


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
        "_plans",
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
        "_cycles",
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
        self._patience = math.ceil(BLOCKED_TIME / self._interval)  # decisions without an open arc

        def setup(plugin: PluginDeclaration) -> Setup:
            return Setup(declaration, known, plugin.parameters, noise)

        self._cover = cover_of(declaration)
        planner, controller = default_plugins(declaration)
        planning = make_plugin(find_planner(planner.plugin), planner.plugin, setup(planner))
        self._plans = Replanning(known, obstacles, declaration, self._cover, planning, self._interval)
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
        self._plans.begin()
        self._cycles = 0  # decisions in this phase
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
        if self._first_distance is None and self._plans.path is not None:
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

    @property
    def plan(self) -> Path | None:
        """The present plan; None without one."""
        return None if self.goal is None else self._plans.path

    def _distance_to_go(self, pose: Pose2) -> float:
        assert self.goal is not None
        poses = self.goal.poses[self._index :]
        later = sum(a.distance(b.x, b.y) for a, b in pairwise(poses))
        if self._plans.path is None:
            return pose.distance(poses[0].x, poses[0].y) + later
        return self._plans.path.length(pose.x, pose.y) + later

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
        # Obstacles that block the robot are on the map of obstacles when it gives up waiting.
        at_once = self._blocked in (1, self._patience - 1)
        is_new = self._plans.update(now, target, is_blocked=self._blocked > 0, at_once=at_once)
        path = self._plans.path
        if is_new and path is not None:
            self._controller.set_plan(path)
        if not self._makes_progress(now.pose):
            return self._start_recovery(now, "made no progress")
        if path is None:
            return self._hold(now, self._no_passage)
        if path.headings is None and not self._can_align:
            return self._end(Outcome.ABORTED, self._no_headings)
        return Following(self._controller, path, now, stops)

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
        if self._plans.path is None:
            aligns = self._can_align and self._cover.is_round
        else:
            aligns = self._can_align and not (follows and self._plans.path.headings is not None)
        return has_arrived(self._declaration, pose, target, self._plans.path, aligns=aligns, follows=follows)

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
                self._obstacles.clear_seen()
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
        turn = align_rate(error)
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
