"""The contract of planners and controllers, the replaceable parts of a robot's navigation.

A plugin is a class below `Planner` or `Controller`. Its package registers it as an entry point of the group
`seoro.navigation.planners` or `seoro.navigation.controllers`; a robot's file may also name it as `module:Class`.
It is made once for each robot, with a `Setup`.

Results depend on inputs and declared state only, so that a run is the same again. Attributes that change are named
in `STATE` (see `stateful.py`). Random numbers come from `Setup.noise`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from bisect import bisect_left
from collections.abc import Mapping
from functools import cached_property
from typing import ClassVar, Generic, TypeVar

import numpy as np

from seoro.deferred import dataclass
from sim_nodes.geometry import Array, Indices, Pose2
from sim_nodes.navigation.maps import Grid, NavigationMap
from sim_nodes.noise import Noise
from sim_nodes.robots.declaration import MobileDeclaration
from sim_nodes.robots.kinematics import Velocity
from sim_nodes.robots.navigation import Parameter
from sim_nodes.sensors.lidar import Scan
from sim_nodes.stateful import Stateful

STANDING = 1e-4  # [m]; shorter steps of a path are turns in place


class InvalidParameter(ValueError):
    """A parameter of a plugin is unknown or invalid."""


class UnsuitableRobot(ValueError):
    """A plugin cannot navigate a robot: its drive or outline makes other demands."""


@dataclass(frozen=True)
class Setup:
    """Robot, map and parameters for a plugin.

    Attributes:
        declaration: Declaration of the robot's base: clearance, drive and `navigation`.
        known: Map of the world.
        parameters: Own parameters of the plugin, from the robot's file.
        noise: Source of random numbers.
    """

    declaration: MobileDeclaration
    known: NavigationMap
    parameters: Mapping[str, Parameter]
    noise: Noise

    def refuse_parameters(self, plugin: str) -> None:
        """Refuse own parameters of a plugin that has none.

        Raises:
            InvalidParameter: There are some.
        """
        if self.parameters:
            raise InvalidParameter(
                f"unknown parameter `{min(self.parameters)}`; the {plugin} has none of its own, "
                "its parameters stand directly under `navigation`"
            )


@dataclass(frozen=True)
class PlanRequest:
    """Inputs of a planner.

    Attributes:
        grid: Grid of the map.
        distance: Distance of each cell's centre to the nearest wall or obstacle [m], shape (columns, rows),
            read-only. It never exceeds that of the map. Obstacles count up to the inflation radius at least.
        start: Pose of the robot in `map`; it may be closer to obstacles than the clearance.
        goal: Goal in `map`.
        tick: Tick of the request, for random numbers.
        deviation: Standard deviation of the localised position [m].
    """

    grid: Grid
    distance: Array
    start: Pose2
    goal: Pose2
    tick: int
    deviation: float = 0.0


@dataclass(frozen=True)
class Path:
    """A path in `map` from the robot to the goal.

    Attributes:
        points: Points of the path, in order, shape (n, 2), n >= 1 [m].
        headings: Heading of the robot at each point, shape (n,) [rad]; None where it faces along the path. With
            headings, the path may lead backwards or sideways. Two points in one place are a turn.
    """

    points: Array
    headings: Array | None = None

    @cached_property
    def poses(self) -> Array:
        """Poses (x, y, yaw) along the path, shape (n, 3)."""
        if self.headings is not None:
            return np.column_stack([self.points, self.headings])
        steps = np.diff(self.points, axis=0, append=self.points[-1:])
        headings = np.arctan2(steps[:, 1], steps[:, 0])
        headings[-1:] = headings[-2:-1]
        return np.column_stack([self.points, headings])

    @cached_property
    def ways(self) -> Indices:
        """Direction of each step: 1 forwards or sideways, -1 backwards, 0 for a turn in place, shape (n - 1,)."""
        steps = np.diff(self.points, axis=0)
        if self.headings is None:
            return np.ones(len(steps), dtype=np.int64)
        cos, sin = np.cos(self.headings[:-1]), np.sin(self.headings[:-1])
        ways: Indices = np.where(cos * steps[:, 0] + sin * steps[:, 1] < 0.0, -1, 1)
        ways[np.hypot(steps[:, 0], steps[:, 1]) < STANDING] = 0
        return ways

    @cached_property
    def gone(self) -> Array:
        """Negative `to_go`, which increases along the path [m], shape (n,)."""
        return -self.to_go

    @cached_property
    def to_go(self) -> Array:
        """Length of the path from each point to its end [m], shape (n,)."""
        steps = np.hypot(*np.diff(self.points, axis=0).T)
        lengths: Array = np.append(np.cumsum(steps[::-1])[::-1], 0.0)
        return lengths

    @cached_property
    def _columns(self) -> Array:
        """Coordinates x and y of the points, shape (2, n) [m]: few rows take less time than few columns."""
        return np.ascontiguousarray(self.points.T)

    @cached_property
    def _rests(self) -> list[float]:
        """Values of `gone`; a search in an array takes several times as long."""
        rests: list[float] = self.gone.tolist()
        return rests

    def nearest(self, x: float, y: float) -> int:
        """Return the index of the point nearest to another one."""
        xs, ys = self._columns
        dx, dy = xs - x, ys - y
        return int((dx * dx + dy * dy).argmin())

    def index_at(self, to_go: float) -> int:
        """Return the index of the first point with at most a length to go [m]; n without one."""
        return bisect_left(self._rests, -to_go)

    def length(self, x: float, y: float) -> float:
        """Return the length of the way from a point along the path to its end [m]."""
        index = self.nearest(x, y)
        return float(self.to_go[index] + np.hypot(*(self.points[index] - (x, y))))


class Plugin(Stateful, ABC):
    """A planner or controller.

    Args:
        setup: Robot, map and parameters.

    Raises:
        InvalidParameter: A parameter is unknown or invalid.
        UnsuitableRobot: The plugin cannot navigate the robot.
    """

    @abstractmethod
    def __init__(self, setup: Setup) -> None: ...


class Planner(Plugin):
    """Finds paths."""

    @abstractmethod
    def plan(self, request: PlanRequest) -> Path | None:
        """Return a path whose first point is at the start and whose last one is the goal; None without one.

        All points keep the clearance from walls and obstacles, except around a start that is closer.
        """


@dataclass(frozen=True)
class ControlInput:
    """Inputs of a controller.

    Attributes:
        pose: Localised pose in `map`.
        velocity: Velocity by odometry.
        scan: Last scan.
        remembered: Points of obstacles in `map` that the scan cannot see, shape (n, 2) [m].
        touched: Whether the bumper is pressed.
        tick: Present tick.
        deviation: Standard deviation of the localised position [m].
    """

    pose: Pose2
    velocity: Velocity
    scan: Scan
    remembered: Array
    touched: bool
    tick: int
    deviation: float = 0.0


class Controller(Plugin):
    """Chooses velocities along a path.

    Attributes:
        FOLLOWS_HEADINGS: Whether it takes the headings of paths. With another one, a robot turns at the goal.
    """

    FOLLOWS_HEADINGS: ClassVar[bool] = True

    @abstractmethod
    def follow(self, path: Path, now: ControlInput, *, stops: bool) -> Velocity | None:
        """Return the velocity along a path, within the limits of the drive; None to stop because it is blocked.

        Args:
            path: The path.
            now: Present inputs.
            stops: Whether the robot stops at the end of the path.
        """

    def begin(self) -> None:
        """Forget the path before: a new goal, or the end of a recovery."""

    def set_plan(self, path: Path) -> None:
        """Accept a new path, which `follow` gets from now on."""


C_co = TypeVar("C_co", bound=Controller, covariant=True)


@dataclass(frozen=True)
class Following(Generic[C_co]):
    """A call of `Controller.follow`, which may be answered together with those of other robots."""

    controller: C_co
    path: Path
    now: ControlInput
    stops: bool
