"""The path of a robot to its next pose, planned again when something changes.

Plans are made at the rate of the planner, or at once when the robot is blocked. A path is kept as long as no
obstacle is on the stretch ahead, and the robot does not become less sure of its place.
"""

from __future__ import annotations

import math

from sim_nodes.geometry import Pose2
from sim_nodes.navigation.contracts import ControlInput, Path, Planner, PlanRequest
from sim_nodes.navigation.cover import Cover
from sim_nodes.navigation.maps import NavigationMap
from sim_nodes.navigation.margins import further_margin
from sim_nodes.navigation.obstacles import ObstacleLayer
from sim_nodes.robots.declaration import MobileDeclaration
from sim_nodes.stateful import Stateful

OFF_PATH = 0.4  # [m] from the path from which a robot needs another one
REVIEW_TIME = 5.0  # [s] after which a path is planned anew if any obstacle has changed
OBSTACLE_MARGIN = 0.3  # [m] beyond twice the clearance up to which planners know the distance of obstacles
SLACK = 0.03  # [m] that an obstacle may be closer to the path than planned
MARGIN_SLACK = 0.06  # [m] by which the margin may grow before another path is planned
STRETCH = 1.0  # [m] of the path ahead that obstacles block; farther ones may be gone until the robot is there


class Replanning(Stateful):
    """The path of one robot.

    Args:
        known: The map.
        obstacles: The obstacle layer.
        declaration: Declaration of the robot.
        cover: Cover of the robot.
        planner: The planner.
        interval: Time between decisions [s].

    Attributes:
        path: The present path; None before the first plan, and where the planner found no path.
    """

    STATE = ("planner", "path", "_planned_for", "_margin", "_decisions")

    def __init__(
        self,
        known: NavigationMap,
        obstacles: ObstacleLayer,
        declaration: MobileDeclaration,
        cover: Cover,
        planner: Planner,
        interval: float,
    ) -> None:
        p = declaration.navigation
        self._grid = known.grid
        self._obstacles = obstacles
        self._cover = cover
        self._interval = interval
        self._period = 1.0 / p.expected_planner_frequency
        self._reach = max(p.inflation_radius, 2.0 * declaration.clearance + OBSTACLE_MARGIN)
        self._least_gap = declaration.clearance - SLACK  # of a path without headings
        self.planner = planner

    def begin(self) -> None:
        """Drop the path, for another goal."""
        self.path: Path | None = None
        self._planned_for: int | None = None  # changes of obstacles
        self._margin = 0.0  # [m] by the localisation
        self._decisions = 0  # since the plan

    def update(self, now: ControlInput, target: Pose2, *, is_blocked: bool, at_once: bool) -> bool:
        """Plan if that is needed; returns whether there is a new plan. Call it once in each decision.

        Args:
            now: Inputs of the decision.
            target: The next pose.
            is_blocked: Whether the robot cannot follow the path now.
            at_once: Whether to plan now if that is needed, not at the rate of the planner.
        """
        self._decisions += 1
        since = self._decisions * self._interval
        due = at_once or since >= self._period
        if self._planned_for is not None and not (due and self._needs_plan(now, since, is_blocked=is_blocked)):
            return False
        self.path = self._plan(now, target)
        if self.path is None and self._obstacles.clear_touched():  # they may be elsewhere, or have left
            self.path = self._plan(now, target)
        self._planned_for, self._decisions = self._obstacles.changes, 0
        self._margin = further_margin(now.deviation)
        return True

    def _plan(self, now: ControlInput, target: Pose2) -> Path | None:
        distance = self._obstacles.distance(self._reach)
        distance.setflags(write=False)
        return self.planner.plan(PlanRequest(self._grid, distance, now.pose, target, now.tick, now.deviation))

    def _needs_plan(self, now: ControlInput, since: float, *, is_blocked: bool) -> bool:
        """Whether the path is missing or blocked, the robot has left it, or it was planned long ago."""
        has_changed = self._planned_for != self._obstacles.changes
        if self.path is None:
            return has_changed
        index = self.path.nearest(now.pose.x, now.pose.y)
        if is_blocked or now.pose.distance(*self.path.points[index].tolist()) > OFF_PATH:
            return True
        if further_margin(now.deviation) > self._margin + MARGIN_SLACK:
            return True
        review = since >= REVIEW_TIME and self.path.headings is None  # plans over poses cost more
        return has_changed and (review or self._is_obstructed(self.path, index))

    def _is_obstructed(self, path: Path, index: int) -> bool:
        """Whether an obstacle is too close to the stretch of the path from a point on."""
        obstacles = self._obstacles.points
        if len(obstacles) == 0:
            return False
        ahead = slice(index, path.index_at(float(path.to_go[index]) - STRETCH) + 1, 2)
        if path.headings is not None:
            gaps = self._cover.gaps_to(obstacles[:, 0], obstacles[:, 1], path.poses[ahead])
            return float(gaps.min()) < -SLACK
        points = path.points[ahead]
        dx, dy = obstacles[:, :1] - points[:, 0], obstacles[:, 1:] - points[:, 1]
        closest = math.sqrt(float((dx * dx + dy * dy).min()))  # `hypot` of all pairs takes five times as long
        return closest < self._least_gap
