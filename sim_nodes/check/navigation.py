"""Conformance tests of planners and controllers: do they fulfil `sim_nodes.navigation.contracts`?

    from sim_nodes.check.navigation import check_planner

    def test_my_planner():
        check_planner(MyPlanner)

The robot is that of `bench`, or another one. It crosses a room with a wall in the middle, through a door of 1 m.
Rules are functions; the first line of the docstring of a rule is its requirement.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import field
from typing import Generic, TypeVar

import numpy as np

from seoro.deferred import dataclass
from sim_nodes import codec
from sim_nodes.check.bench import BASE, expect, expect_near
from sim_nodes.check.room import ALONG, AT_WALL, CLOSED_ROOM, GOAL, GOALS, ROOM, START, path_for, start_of
from sim_nodes.geometry import Array, Pose2, wrap
from sim_nodes.navigation.contracts import ControlInput, Controller, Path, Planner, PlanRequest, Setup
from sim_nodes.navigation.maps import NavigationMap
from sim_nodes.noise import Noise
from sim_nodes.robots.declaration import MobileDeclaration
from sim_nodes.robots.kinematics import AT_REST, Velocity
from sim_nodes.robots.navigation import Parameter
from sim_nodes.sensors.lidar import BLIND, Scan

P = TypeVar("P", Planner, Controller)


@dataclass(frozen=True)
class Make(Generic[P]):
    """Makes a plugin, by its class or another factory, for a map, a robot and parameters."""

    plugin: Callable[[Setup], P]
    base: MobileDeclaration = BASE
    parameters: Mapping[str, Parameter] = field(default_factory=dict)

    def __call__(self, known: NavigationMap) -> P:
        """Return a new one."""
        return self.plugin(Setup(self.base, known, self.parameters, Noise(0, "check")))


LEAVING = 0.35  # [m] around a start at an obstacle, where the clearance is not required
SLACK = 0.025  # [m] of the clearance: half a cell
EXACT = 1e-6
ASIDE = 0.1  # [rad] of a step from the heading
TIGHTER, BEND = 0.98, 1e-3  # share of the turning radius, and turn of a step beyond it [rad], that are allowed
INTERVAL = 0.1  # [s] between decisions
MOST_DECISIONS = 600
ARRIVED, BEAMS = 0.05, 360  # [m], number of beams of a scan


def check_planner(
    make: Callable[[Setup], Planner],
    parameters: Mapping[str, Parameter] | None = None,
    base: MobileDeclaration = BASE,
) -> None:
    """Check a planner by all rules.

    Args:
        make: Its class, or another factory. It is called several times.
        parameters: Parameters of the planner; none by default.
        base: Declaration of the robot, such as a car; a TurtleBot by default.

    Raises:
        AssertionError: The planner breaks a rule; the message gives the rule and the observation.
    """
    for rule in PLANNER_RULES:
        _check(rule, Make(make, base, parameters or {}))


def check_controller(
    make: Callable[[Setup], Controller],
    parameters: Mapping[str, Parameter] | None = None,
    base: MobileDeclaration = BASE,
) -> None:
    """Check a controller by all rules.

    Args:
        make: Its class, or another factory. It is called several times.
        parameters: Parameters of the controller; none by default.
        base: Declaration of the robot, such as a car; a TurtleBot by default.

    Raises:
        AssertionError: The controller breaks a rule; the message gives the rule and the observation.
    """
    for rule in CONTROLLER_RULES:
        _check(rule, Make(make, base, parameters or {}))


def paths_lead_from_start_to_goal(make: Make[Planner]) -> None:
    """Paths are finite points of shape (n, 2), from the start to the goal, within 1e-6 m."""
    planner = make(ROOM)
    for goal in GOALS:
        points = _planned(planner, START, goal).points
        expect(points.ndim == 2 and points.shape[1] == 2, f"a path has the shape {points.shape}")
        expect(bool(np.isfinite(points).all()), "a path has points that are not finite")
        expect_near("the first point of a path [m]", points[0], START[:2], EXACT)
        expect_near("the last point of a path [m]", points[-1], goal[:2], EXACT)


def paths_keep_the_clearance(make: Make[Planner]) -> None:
    """Paths keep the clearance from walls, also between their points, within half a cell."""
    planner = make(ROOM)
    for goal in GOALS:
        room, clearance = _room_along(_planned(planner, START, goal)), make.base.clearance
        expect(
            room >= clearance - SLACK,
            f"a path to ({goal.x}, {goal.y}) is {room:.3f} m from a wall; the clearance is {clearance} m",
        )


def robots_at_walls_can_leave(make: Make[Planner]) -> None:
    """A robot closer to a wall than the clearance gets a path, which keeps the clearance after 0.35 m."""
    points = _planned(make(ROOM), AT_WALL, GOAL).points
    away = np.hypot(*(points - AT_WALL[:2]).T) > LEAVING
    room = float(ROOM.grid.interpolate(ROOM.distance, *points[away].T).min())
    expect(room >= make.base.clearance - SLACK, f"the path away is {room:.3f} m from a wall")


def goals_behind_walls_are_unreachable(make: Make[Planner]) -> None:
    """Planners return None for goals behind closed walls."""
    path = make(CLOSED_ROOM).plan(_request(CLOSED_ROOM, START, GOAL))
    expect(path is None, "a path leads through a wall")


def headings_fit_the_path(make: Make[Planner]) -> None:
    """Headings, if a path has any, are those of start and goal at its ends, and along or against its steps."""
    planner = make(ROOM)
    for goal in GOALS:
        path = _planned(planner, START, goal)
        if path.headings is None:
            continue
        expect(path.headings.shape == path.points.shape[:1], f"headings have the shape {path.headings.shape}")
        ends = wrap(path.headings[[0, -1]] - np.array((START.yaw, goal.yaw)))
        expect_near("the headings at the ends, relative to start and goal [rad]", ends, (0.0, 0.0), EXACT)
        steps, drives = np.diff(path.points, axis=0), path.ways != 0
        middle = path.headings[:-1] + wrap(np.diff(path.headings)) / 2.0
        off = wrap(np.arctan2(steps[:, 1], steps[:, 0]) - middle)[drives]
        aside = float(np.minimum(np.abs(off), np.pi - np.abs(off)).max(initial=0.0))
        fits = make.base.drive.max_lateral_speed > 0.0 or aside < ASIDE
        expect(fits, f"a step leads {aside:.2f} rad aside of the heading; the robot cannot move sideways")


def cars_can_follow_paths(make: Make[Planner]) -> None:
    """Paths of cars have headings, turn nowhere in place, and bend no tighter than the car."""
    radius, planner = make.base.drive.min_turning_radius, make(ROOM)
    for goal in GOALS if radius else ():
        path = _planned(planner, START, goal)
        if path.headings is None:
            raise AssertionError("a path has no headings")
        turns, lengths = np.abs(wrap(np.diff(path.headings))), np.hypot(*np.diff(path.points, axis=0).T)
        expect(float(turns[path.ways == 0].max(initial=0.0)) < EXACT, "a path turns in place")
        # Steps are chords: the curve is a little longer.
        sharpest = float((turns - lengths / (TIGHTER * radius)).max(initial=0.0))
        expect(sharpest < BEND, f"a step turns {sharpest:.3f} rad more than a curve of {radius:g} m")


def plans_are_repeatable(make: Make[Planner]) -> None:
    """Two planners return identical paths for the same requests."""
    first, second = (_plans(make(ROOM)) for _ in range(2))
    expect(first == second, "two planners returned different paths for the same requests")


def restored_planners_continue_identically(make: Make[Planner]) -> None:
    """A planner with the state of another one, by `STATE`, continues with identical paths."""
    planner, restored = make(ROOM), make(ROOM)
    _plans(planner)
    restored.restore(codec.unpack(codec.pack(planner.save())))
    expect(_plans(planner) == _plans(restored), "a restored planner returned other paths")


def controllers_reach_the_goal(make: Make[Controller]) -> None:
    """A controller leads a robot without errors along a path to its end, within 5 cm in 60 s."""
    path = path_for(make.base)
    end = _drive(make(ROOM), path)[-1][0]
    expect_near("the end of the drive [m]", end[:2], path.points[-1], ARRIVED)


def velocities_are_within_limits(make: Make[Controller]) -> None:
    """Velocities are finite and within the limits of the drive; cars turn by curves only."""
    drive = make.base.drive
    for _, velocity in _drive(make(ROOM), path_for(make.base)):
        fast = abs(velocity.linear) <= drive.max_speed + EXACT
        turning = abs(velocity.angular) <= drive.max_turn_rate + EXACT
        lateral = abs(velocity.lateral) <= drive.max_lateral_speed + EXACT
        expect(fast and turning and lateral, f"{velocity} exceeds the limits of the drive")
        curve = drive.min_turning_radius * abs(velocity.angular) <= abs(velocity.linear) + EXACT
        expect(curve, f"{velocity} is a curve tighter than {drive.min_turning_radius:g} m")


def controllers_stop_before_obstacles(make: Make[Controller]) -> None:
    """A robot with obstacles all around, 1 cm beyond its radius, does not drive."""
    path = path_for(make.base)
    here = ALONG if path.headings is None else start_of(path)
    velocity = make(ROOM).follow(path, _input(here, _ring(make.base.radius + 0.01)), stops=True)
    stands = velocity is None or velocity.linear == velocity.lateral == 0.0
    expect(stands, f"the robot drives into them at {velocity}")


def control_is_repeatable(make: Make[Controller]) -> None:
    """Two controllers return identical velocities for the same inputs."""
    path = path_for(make.base)
    expect(_drive(make(ROOM), path) == _drive(make(ROOM), path), "two controllers returned different velocities")


def restored_controllers_continue_identically(make: Make[Controller]) -> None:
    """A controller with the state of another one, by `STATE`, continues with identical velocities."""
    controller, restored, path = make(ROOM), make(ROOM), path_for(make.base)
    driven = _drive(controller, path, decisions=30)
    restored.restore(codec.unpack(codec.pack(controller.save())))
    here = driven[-1][0]
    same = _drive(controller, path, here, begins=False) == _drive(restored, path, here, begins=False)
    expect(same, "a restored controller returned other velocities")


PLANNER_RULES = (
    paths_lead_from_start_to_goal,
    paths_keep_the_clearance,
    robots_at_walls_can_leave,
    goals_behind_walls_are_unreachable,
    headings_fit_the_path,
    cars_can_follow_paths,
    plans_are_repeatable,
    restored_planners_continue_identically,
)
CONTROLLER_RULES = (
    controllers_reach_the_goal,
    velocities_are_within_limits,
    controllers_stop_before_obstacles,
    control_is_repeatable,
    restored_controllers_continue_identically,
)


def _check(rule: Callable[[Make[P]], None], make: Make[P]) -> None:
    try:
        rule(make)
    except AssertionError as error:
        demand = (rule.__doc__ or rule.__name__).partition("\n")[0]
        raise AssertionError(f"{demand} But {error}") from error


def _request(known: NavigationMap, start: Pose2, goal: Pose2) -> PlanRequest:
    distance = known.distance.view()
    distance.setflags(write=False)
    return PlanRequest(known.grid, distance, start, goal, 0)


def _planned(planner: Planner, start: Pose2, goal: Pose2) -> Path:
    path = planner.plan(_request(ROOM, start, goal))
    if path is None:
        raise AssertionError(f"found None; expected a path from ({start.x}, {start.y}) to ({goal.x}, {goal.y})")
    return path


def _plans(planner: Planner) -> list[list[float]]:
    """Return the paths to all goals, as numbers."""
    return [_planned(planner, START, goal).points.ravel().tolist() for goal in GOALS]


def _room_along(path: Path) -> float:
    """Return the least distance to walls on a path [m]."""
    pieces = np.linspace(path.points[:-1], path.points[1:], 20).reshape(-1, 2)
    points = np.vstack([path.points, pieces])
    return float(ROOM.grid.interpolate(ROOM.distance, *points.T).min())


def _input(pose: Pose2, scan: Scan, velocity: Velocity = AT_REST, tick: int = 0) -> ControlInput:
    return ControlInput(pose, velocity, scan, np.zeros((0, 2)), touched=False, tick=tick)


def _ring(radius: float) -> Scan:
    """Return a scan of obstacles all around the base, with the lidar at its origin."""
    angles: Array = np.linspace(-math.pi, math.pi, BEAMS, endpoint=False)
    return Scan(
        np.full(BEAMS, radius), angles, Pose2(0.0, 0.0, 0.0), radius * np.cos(angles), radius * np.sin(angles)
    )


def _drive(
    controller: Controller,
    path: Path,
    start: Pose2 | None = None,
    *,
    begins: bool = True,
    decisions: int = MOST_DECISIONS,
) -> list[tuple[Pose2, Velocity]]:
    """Drive along a path without errors, by default from its start; returns poses and velocities."""
    pose, velocity = start or start_of(path), AT_REST
    end = path.points[-1].tolist()
    driven = []
    if begins:
        controller.begin()
    for decision in range(decisions):
        found = controller.follow(path, _input(pose, BLIND, velocity, decision), stops=True)
        if found is None:
            raise AssertionError(f"the robot is blocked at ({pose.x:.2f}, {pose.y:.2f}) on free floor")
        velocity = found
        pose = _moved(pose, velocity)
        driven.append((pose, velocity))
        if pose.distance(*end) < ARRIVED / 2:
            break
    return driven


def _moved(pose: Pose2, velocity: Velocity) -> Pose2:
    """Return the pose after an interval, by the midpoint rule."""
    yaw = pose.yaw + velocity.angular * INTERVAL / 2
    ahead, left = velocity.linear * INTERVAL, velocity.lateral * INTERVAL
    return Pose2(
        pose.x + math.cos(yaw) * ahead - math.sin(yaw) * left,
        pose.y + math.sin(yaw) * ahead + math.cos(yaw) * left,
        pose.yaw + velocity.angular * INTERVAL,
    )
