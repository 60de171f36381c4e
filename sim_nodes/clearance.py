"""Distances between robots that drive and other entities, from above."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import assert_never

import numpy as np

from sim_nodes.entities import Entities
from sim_nodes.geometry import Array, Pose2, rotation_matrix
from sim_nodes.navigation.maps import NavigationMap
from sim_nodes.physics import BodyModel, BodyState, Box, Capsule, Cylinder, Engine, Hull, Part, Sphere, Wall


@dataclass(frozen=True)
class Clearance:
    """Distance to the nearest entity [m], and its name; infinite and empty without any."""

    distance: float = math.inf
    entity: str = ""


class WallDistance:
    """Distances to the nearest of a set of walls."""

    def __init__(self, walls: Sequence[Wall]) -> None:
        self._names = tuple(wall.name for wall in walls)
        self._centre = np.array([(wall.x, wall.y) for wall in walls]).reshape(-1, 2)
        self._half = np.array([(wall.length / 2, wall.thickness / 2) for wall in walls]).reshape(-1, 2)
        yaw = np.array([wall.yaw for wall in walls])
        self._cos, self._sin = np.cos(yaw), np.sin(yaw)

    def at(self, x: float, y: float) -> float:
        """Return the distance of a point [m]; 0 inside a wall, infinite without walls."""
        return self.nearest(x, y).distance

    def nearest(self, x: float, y: float) -> Clearance:
        """Return the distance of a point to the nearest wall, and the wall."""
        if not self._names:
            return Clearance()
        dx, dy = x - self._centre[:, 0], y - self._centre[:, 1]
        along = np.abs(self._cos * dx + self._sin * dy) - self._half[:, 0]
        across = np.abs(self._cos * dy - self._sin * dx) - self._half[:, 1]
        distances = np.hypot(along.clip(0.0), across.clip(0.0))
        index = int(distances.argmin())
        return Clearance(float(distances[index]), self._names[index])


def distance_to_body(model: BodyModel, state: BodyState, x: float, y: float) -> float:
    """Return the distance of a point to a body [m]; 0 inside. Parts at all heights count."""
    body = rotation_matrix(state.orientation)
    distances = (_distance_to_part(part, body, np.array(state.position), x, y) for part in model.parts)
    return min(distances, default=math.inf)


def _distance_to_part(part: Part, body: Array, position: Array, x: float, y: float) -> float:
    centre = position + body @ part.position
    turned = body @ rotation_matrix(part.orientation)
    local = turned.T @ np.array([x - centre[0], y - centre[1], 0.0])
    match part.shape:
        case Box(size=size):
            return float(np.hypot.reduce((np.abs(local) - np.array(size) / 2).clip(0.0)))
        case Cylinder(radius=radius, length=length):
            across = max(0.0, math.hypot(local[0], local[1]) - radius)
            return math.hypot(across, max(0.0, abs(float(local[2])) - length / 2))
        case Sphere(radius=radius):
            return max(0.0, float(np.hypot.reduce(local)) - radius)
        case Capsule(radius=radius, length=length):
            along = max(0.0, abs(float(local[2])) - length / 2)
            return max(0.0, math.hypot(local[0], local[1], along) - radius)
        case Hull():
            return _distance_to_hull(part.shape, local)
        case _:
            assert_never(part.shape)


def _distance_to_hull(hull: Hull, point: Array) -> float:
    """Return the distance of a point to a convex hull [m], by minimizing over weights of its corners."""
    from scipy.optimize import nnls  # noqa: PLC0415 - for meshes only

    # Weights of the corners are not negative and sum to one, which a large factor enforces.
    corners = hull.points.T
    scale = 1e3 * max(1.0, float(np.abs(corners - point[:, None]).max()))
    matrix = np.vstack([corners - point[:, None], np.full(corners.shape[1], scale)])
    weights, _ = nnls(matrix, np.array([0.0, 0.0, 0.0, scale]))
    return float(np.linalg.norm((corners - point[:, None]) @ weights))


class Clearances:
    """Distances of the circles of robots to other entities, from above.

    Args:
        engine: Engine with the present states.
        walls: Walls of the world.
        entities: Entities of the world.
        radii: Radii of the robots that drive [m], by name.
        known: Map of the walls, which bounds their distance from below.
    """

    def __init__(
        self,
        engine: Engine,
        walls: Sequence[Wall],
        entities: Entities,
        radii: Mapping[str, float],
        known: NavigationMap,
    ) -> None:
        self._engine = engine
        self._known = known
        self._entities = entities
        self._radii = radii
        self._walls = WallDistance(walls)
        self._walls_by_name = {
            name: WallDistance([wall for wall in walls if wall.name == name])
            for name in {wall.name for wall in walls}
        }

    @property
    def names(self) -> list[str]:
        """Names of the entities to which there is a distance."""
        return [*self._walls_by_name, *self._entities.bodies, *self._radii]

    def nearest(self, robot: str, pose: Pose2, within: float = math.inf) -> Clearance:
        """Return the nearest of all walls, bodies and other robots that drive; 0 m at least.

        Args:
            robot: Name of the robot.
            pose: Its pose in `map`.
            within: Distance from which entities are left out [m]; the result has none if all are left out.
        """
        limit = within + self._radii[robot]
        best = Clearance(limit)
        if self._least_to_walls(pose) < limit:
            best = min(best, self._walls.nearest(pose.x, pose.y), key=_distance)
        for name, model in self._entities.bodies.items():
            best = self._nearer(best, name, model, pose)
        for other in self._radii:
            if other != robot:
                best = self._nearer_robot(best, other, pose)
        return self._from_outline(robot, best) if best.entity else Clearance()

    def _least_to_walls(self, pose: Pose2) -> float:
        """Return a lower bound of the distance to walls, without computing it [m]."""
        grid = self._known.grid
        if not grid.contains(pose.x, pose.y):
            return 0.0
        return float(self._known.distance[grid.cell(pose.x, pose.y)]) - grid.resolution

    def between(self, robot: str, pose: Pose2, other: str) -> Clearance:
        """Return the distance to one entity, which is one of `names`; 0 m at least."""
        bodies = self._entities.bodies
        if other in self._walls_by_name:
            distance = self._walls_by_name[other].at(pose.x, pose.y)
        elif other in bodies:
            distance = distance_to_body(bodies[other], self._engine.body_state(other), pose.x, pose.y)
        elif other in self._radii:
            distance = self._to_robot(other, pose)
        else:
            return Clearance()  # deleted
        return self._from_outline(robot, Clearance(distance, other))

    def _nearer(self, best: Clearance, name: str, model: BodyModel, pose: Pose2) -> Clearance:
        state = self._engine.body_state(name)
        x, y, _ = state.position
        if pose.distance(x, y) - model.reach >= best.distance:
            return best
        return min(best, Clearance(distance_to_body(model, state, pose.x, pose.y), name), key=_distance)

    def _to_robot(self, other: str, pose: Pose2) -> float:
        x, y, _ = self._engine.body_state(other).position
        return pose.distance(x, y) - self._radii[other]

    def _nearer_robot(self, best: Clearance, other: str, pose: Pose2) -> Clearance:
        x, y, _ = self._engine.body_state(other).position
        reach = best.distance + self._radii[other]
        if abs(pose.x - x) >= reach or abs(pose.y - y) >= reach:
            return best
        return min(best, Clearance(self._to_robot(other, pose), other), key=_distance)

    def _from_outline(self, robot: str, found: Clearance) -> Clearance:
        return Clearance(max(0.0, found.distance - self._radii[robot]), found.entity)


def _distance(clearance: Clearance) -> float:
    return clearance.distance
