"""Lengths of the shortest paths of a map, which measured paths are compared with."""

from __future__ import annotations

import math

import numpy as np

from sim_nodes.check.bench import BASE
from sim_nodes.geometry import Array, Pose2, lengths_along
from sim_nodes.navigation.contracts import PlanRequest, Setup
from sim_nodes.navigation.cover import cover_of
from sim_nodes.navigation.hybrid import SPARE
from sim_nodes.navigation.lattice import connect, relative
from sim_nodes.navigation.maps import NavigationMap
from sim_nodes.navigation.mobility import CarMobility
from sim_nodes.navigation.planner import GridPlanner
from sim_nodes.navigation.smoothing import smooth
from sim_nodes.noise import Noise
from sim_nodes.robots.declaration import MobileDeclaration

ROUNDS = 5  # of smoothing


def shortest_length(declaration: MobileDeclaration, known: NavigationMap, start: Pose2, goal: Pose2) -> float:
    """Return the length of the shortest path [m]; infinite without a path.

    A round robot keeps the clearance of the planner. Of other robots, the inscribed circle with its margin fits,
    which is a lower bound. A car also steers with the radius of the planner where it leaves the start and reaches
    the goal. There it may drive backwards, and its outline fits.

    Args:
        declaration: Declaration of the robot.
        known: The map, with all obstacles.
        start: Pose of the robot.
        goal: Pose to reach.
    """
    points = _taut_path(declaration, known, start, goal)
    if points is None:
        return math.inf
    if not declaration.drive.min_turning_radius:
        return float(lengths_along(points)[-1])
    return _steered_length(declaration, known, points, start, goal)


def _taut_path(declaration: MobileDeclaration, known: NavigationMap, start: Pose2, goal: Pose2) -> Array | None:
    """Return the shortest path of a disc, shape (n, 2)."""
    clearance = cover_of(declaration).room
    navigation = declaration.navigation.model_copy(update={"inflation_cost": 0.0})
    turning = {"navigation": navigation, "clearance": clearance, "drive": BASE.drive}  # `grid` refuses cars
    cheap = declaration.model_copy(update=turning)
    planner = GridPlanner(Setup(cheap, known, {}, Noise(0, "shortest")))
    path = planner.plan(PlanRequest(known.grid, known.distance, start, goal, 0))
    if path is None:
        return None
    points = path.points
    for _ in range(ROUNDS):
        points = smooth(known.grid, known.distance, points, clearance)
    return points


def _steered_length(
    declaration: MobileDeclaration, known: NavigationMap, points: Array, start: Pose2, goal: Pose2
) -> float:
    """Return the least length of connections of start and goal with the path, and the part between them [m]."""
    mobility = CarMobility(SPARE * declaration.drive.min_turning_radius, reverse_penalty=1.0)
    cover = cover_of(declaration)
    ways = np.gradient(points, axis=0)
    path = np.column_stack([points, np.arctan2(ways[:, 1], ways[:, 0])])

    def length(first: Array, last: Array) -> float:
        poses = connect(mobility, first, last)
        fits = cover.gaps(known.grid, known.distance, poses).min() >= 0.0
        return float(mobility.costs(relative(first, last)[None])[0]) if fits else math.inf

    begin, end = np.array(start), np.array(goal)
    along = lengths_along(points)
    joined = np.array([length(begin, pose) for pose in path]) - along
    left = np.array([length(pose, end) for pose in path]) + along
    through = float((np.minimum.accumulate(joined) + left).min())
    return min(length(begin, end), through)
