"""Local control by the dynamic window approach (Fox, Burgard, Thrun 1997) over a cost-to-go.

Each cycle rolls out arcs of constant velocity and drops those on which the robot could not stop before an
obstacle. It takes the arc whose safe end is best: lowest cost to go from there, and ahead of there.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from sim_nodes.geometry import Array, Pose2
from sim_nodes.navigation.maps import Grid
from sim_nodes.navigation.planner import Plan
from sim_nodes.robots.declaration import MobileDeclaration
from sim_nodes.robots.kinematics import AT_REST, Velocity
from sim_nodes.sensors.lidar import Scan
from sim_nodes.stateful import Stateful

HORIZON = 1.5  # [s]
SAMPLES = 12  # points on an arc
SPEEDS, TURN_RATES = 6, 21  # numbers of candidates
WINDOW = 0.25  # [s] of acceleration between the present velocity and the candidates
TURN_RATE = 1.5  # [rad/s]; below the robots' limit, for the sake of localisation
LATENCY = 0.15  # [s] from an obstacle's appearance to braking: scan, cycle, wheels
NEIGHBOURS = 4  # number of adjacent beams that must end ahead to indicate an obstacle
STOP_MARGIN = 0.05  # [m] after stopping before an obstacle
LOOK_AHEAD = 0.25  # [m] beyond the end of an arc, along its heading
LOOK_AHEAD_WEIGHT = 0.7
WALL_AHEAD_COST = 50.0  # maximum, per metre of look-ahead, for heading towards a wall
STEADINESS = 0.03  # cost of changing the turn rate [m / (rad/s)]
IDLE = (0.01, 0.05)  # [m/s], [rad/s]; below this speed the robot counts as blocked
APPROACH_DISTANCE = 0.3  # [m] from the goal
UNREACHABLE = 1e6  # cost-to-go of unreachable cells


class LocalController(Stateful):
    """Chooses velocities for a robot.

    Attributes:
        velocity: The last velocity; the accelerations limit the change to the next.
    """

    STATE = ("velocity",)
    DERIVED = ("_plan", "_open", "_finite")  # derived from the followed plan

    def __init__(self, grid: Grid, declaration: MobileDeclaration, interval: float) -> None:
        self._grid = grid
        self._drive = declaration.drive
        self._radius = declaration.radius
        self._clearance = declaration.clearance
        self._interval = interval
        self._times = np.linspace(HORIZON / SAMPLES, HORIZON, SAMPLES)
        fastest_turn = min(TURN_RATE, self._drive.max_turn_rate)
        self._turn_rates = np.linspace(-fastest_turn, fastest_turn, TURN_RATES)
        self._plan: Plan | None = None
        self.velocity = AT_REST

    def follow(self, plan: Plan, pose: Pose2, distance: Array, scan: Scan, speed_limit: float) -> Velocity | None:
        """Return the next velocity towards the goal of a plan; None if every arc is blocked.

        Args:
            plan: The plan.
            pose: Pose of the base in `map`.
            distance: Distance of each cell to the nearest wall or obstacle [m].
            scan: The last scan; it counts before its points become obstacles.
            speed_limit: Maximum speed [m/s].
        """
        speeds, turns = self._window(min(speed_limit, self._speed_before(scan)))
        x, y, heading = self._rollout(pose, speeds, turns)
        safe, admissible = self._safe_points(pose, speeds, x, y, distance)
        score = self._score(plan, pose, x, y, heading, safe, turns)
        score[np.logical_not(admissible)] = np.inf
        best = int(score.argmin())
        idle = (speeds < IDLE[0]) & (np.abs(turns) < IDLE[1])
        if idle[best]:
            # Standing still may look best because of the floor ahead, which only a curve leads to.
            to_go = self._to_go(plan, pose, x[:, -1], y[:, -1])
            score[idle | (safe < SAMPLES - 1) | (to_go >= to_go[best])] = np.inf
            best = int(score.argmin())
        if score[best] >= UNREACHABLE:
            return None
        return self.steer(Velocity(float(speeds[best]), float(turns[best])))

    def steer(self, wanted: Velocity) -> Velocity:
        """Return the velocity nearest to `wanted` within the limits of turn rate and accelerations."""
        dv, dw = self._drive.max_acceleration * self._interval, self._drive.max_turn_acceleration * self._interval
        v, w, _ = self.velocity
        limit = self._drive.max_turn_rate
        turn = min(max(wanted.angular, -limit), limit)
        self.velocity = Velocity(min(max(wanted.linear, v - dv), v + dv), min(max(turn, w - dw), w + dw))
        return self.velocity

    def stop(self) -> Velocity:
        """Return zero velocity at once, regardless of accelerations."""
        self.velocity = AT_REST
        return AT_REST

    def _window(self, limit: float) -> tuple[Array, Array]:
        reach = self._drive.max_acceleration * WINDOW
        now = self.velocity.linear
        fastest = max(0.0, min(limit, self._drive.max_speed, now + reach))
        slowest = min(fastest, max(0.0, now - reach))
        tried = np.concatenate([[0.0], np.linspace(slowest, fastest, SPEEDS)])
        speeds, turns = np.meshgrid(tried, self._turn_rates, indexing="ij")
        return speeds.ravel(), turns.ravel()

    def _speed_before(self, scan: Scan) -> float:
        """Return the maximum speed from which the robot stops before obstacles in its way.

        An obstacle stops all adjacent beams, noise only some: the farthest of neighbouring beams counts.
        """
        hit = scan.hit
        x, y = scan.x[hit], scan.y[hit]
        ahead = (np.abs(y) < self._radius) & (x > 0.0)
        if np.count_nonzero(ahead) < NEIGHBOURS:
            return self._drive.max_speed
        room = np.full(len(x), np.inf)
        # The round front of the robot reaches obstacles at its sides later than those in the middle.
        room[ahead] = x[ahead] - np.sqrt(self._radius**2 - y[ahead] ** 2)
        nearest = float(sliding_window_view(room, NEIGHBOURS).max(axis=1).min())
        return self._stoppable_speed(max(nearest - STOP_MARGIN, 0.0)) if math.isfinite(nearest) else np.inf

    def _stoppable_speed(self, room: float) -> float:
        """Solve v * latency + v^2 / 2a = room for v."""
        a = self._drive.max_acceleration
        return -a * LATENCY + math.sqrt((a * LATENCY) ** 2 + 2.0 * a * room)

    def _rollout(self, pose: Pose2, speeds: Array, turns: Array) -> tuple[Array, Array, Array]:
        """Return points x, y and heading of the arcs, each of shape (arcs, SAMPLES)."""
        heading = turns[:, None] * self._times
        # Along a chord: 2 r sin(a/2) at half the angle; numpy's sinc is of pi times its argument.
        chord = speeds[:, None] * self._times * np.sinc(heading / (2.0 * math.pi))
        direction = pose.yaw + heading / 2.0
        return pose.x + chord * np.cos(direction), pose.y + chord * np.sin(direction), pose.yaw + heading

    def _safe_points(self, pose: Pose2, speeds: Array, x: Array, y: Array, distance: Array) -> tuple[Array, Array]:
        """Return the index of the last safe point of each arc (-1: none), and whether the robot can stop there."""
        room = distance[self._grid.cells(x, y)]
        here = float(distance[self._grid.cell(pose.x, pose.y)])
        # A robot that is too close already may move to points at the same distance or farther.
        needed = min(self._clearance, here - 1e-3)
        blocked = room < needed
        first = np.where(blocked.any(axis=1), blocked.argmax(axis=1), SAMPLES)
        way = speeds * first * (HORIZON / SAMPLES)
        braking = speeds * LATENCY + speeds**2 / (2.0 * self._drive.max_acceleration) + STOP_MARGIN
        return first - 1, (first == SAMPLES) | (way >= braking) | (speeds == 0.0)

    def _score(
        self, plan: Plan, pose: Pose2, x: Array, y: Array, heading: Array, safe: Array, turns: Array
    ) -> Array:
        arc, last = np.arange(len(safe)), safe.clip(0).astype(np.int64)
        end_x, end_y, end_heading = x[arc, last], y[arc, last], heading[arc, last]
        ahead = min(LOOK_AHEAD, pose.distance(*plan.goal) / 2.0)
        there = self._to_go(plan, pose, end_x, end_y)
        ahead_x, ahead_y = end_x + ahead * np.cos(end_heading), end_y + ahead * np.sin(end_heading)
        beyond = self._to_go(plan, pose, ahead_x, ahead_y)
        # A wall ahead of the end is bad, but the end itself counts more.
        beyond = np.minimum(beyond, there + WALL_AHEAD_COST * ahead)
        score: Array = there + LOOK_AHEAD_WEIGHT * beyond + STEADINESS * np.abs(turns - self.velocity.angular)
        return score

    def _to_go(self, plan: Plan, pose: Pose2, x: Array, y: Array) -> Array:
        """Return the cost to go from points; near the goal, the distance, because cells are too coarse."""
        if pose.distance(*plan.goal) < APPROACH_DISTANCE:
            way: Array = np.hypot(x - plan.goal[0], y - plan.goal[1])
            return way
        if plan is not self._plan:
            self._plan = plan
            self._open = np.isfinite(plan.cost_to_go).astype(np.float64)
            self._finite = np.where(np.isfinite(plan.cost_to_go), plan.cost_to_go, 0.0)
        # Closed cells have no cost to go, and must not affect the open ones beside them.
        weight = self._grid.interpolate(self._open, x, y)
        value = self._grid.interpolate(self._finite, x, y)
        return np.where(weight > 0.0, value / np.maximum(weight, 1e-9), UNREACHABLE)
