"""Distances between robots that drive and other entities, from above."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import assert_never

import numpy as np

from seoro.deferred import dataclass
from sim_nodes.entities import Entities
from sim_nodes.geometry import Array, Pose2, rotation_matrix
from sim_nodes.near_walls import NearWalls, PlacedWall
from sim_nodes.physics import BodyModel, BodyState, Box, Capsule, Cylinder, Engine, Hull, Part, Sphere, Wall
from sim_nodes.polygons import Shadow, distance_from_polygon, distance_to_shadow, placed_corners
from sim_nodes.robots.declaration import MobileDeclaration
from sim_nodes.stateful import Stateful

AROUND = 0.25  # [m] a robot moves before the walls near it are chosen again


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
        along, across = np.column_stack([self._cos, self._sin]), np.column_stack([-self._sin, self._cos])
        end, side = along * self._half[:, :1], across * self._half[:, 1:]
        corners = np.stack([end + side, side - end, -end - side, end - side], axis=1)
        self._corners = self._centre[:, None] + corners  # counterclockwise
        numbers = np.column_stack([self._centre, self._cos, self._sin, self._half])
        self._placed = tuple(map(PlacedWall, self._names, *numbers.T.tolist()))

    def at(self, x: float, y: float) -> float:
        """Return the distance of a point [m]; 0 inside a wall, infinite without walls."""
        return self.nearest(x, y).distance

    def nearest(self, x: float, y: float) -> Clearance:
        """Return the distance of a point to the nearest wall, and the wall."""
        if not self._names:
            return Clearance()
        distances = self._distances(x, y)
        index = int(distances.argmin())
        return Clearance(float(distances[index]), self._names[index])

    def nearest_to_polygon(self, polygon: PlacedPolygon, within: float) -> Clearance:
        """Return the distance of a polygon to the nearest wall that is nearer than `within` [m], and the wall."""
        best = Clearance(within)
        from_origin = self._distances(polygon.x, polygon.y)
        for index in np.argsort(from_origin).tolist():
            if from_origin[index] - polygon.reach >= best.distance:
                break
            distance = distance_to_shadow(polygon.corners, Shadow(self._corners[index]))
            if distance < best.distance:
                best = Clearance(distance, self._names[index])
        return best if best.entity else Clearance()

    def near(self, x: float, y: float, reach: float) -> NearWalls:
        """Return the walls that are the nearest ones of places up to `reach` from a place [m]."""
        distances = self._distances(x, y)
        near = distances <= distances.min(initial=math.inf) + 2.0 * reach
        return NearWalls(x, y, reach, tuple([self._placed[index] for index in np.flatnonzero(near)]))

    def _distances(self, x: float, y: float) -> Array:
        """Return the distance of a point to each wall [m]."""
        dx, dy = x - self._centre[:, 0], y - self._centre[:, 1]
        along = np.abs(self._cos * dx + self._sin * dy) - self._half[:, 0]
        across = np.abs(self._cos * dy - self._sin * dx) - self._half[:, 1]
        distances: Array = np.hypot(np.maximum(along, 0.0), np.maximum(across, 0.0))
        return distances


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


@dataclass(frozen=True)
class PlacedDisc:
    """The circle of a robot without a footprint: its centre in `map` and its radius `reach` [m]."""

    x: float
    y: float
    reach: float

    @property
    def shadow(self) -> Shadow:
        """Its shape from above."""
        return Shadow(np.array([(self.x, self.y)]), self.reach)

    def to_walls(self, _: WallDistance, from_origin: Clearance, __: float) -> Clearance:
        """Return the nearest wall, given that of the origin; the distance is negative if they overlap [m]."""
        return Clearance(from_origin.distance - self.reach, from_origin.entity)

    def to_body(self, model: BodyModel, state: BodyState) -> float:
        """Return the distance to a body [m], negative if they overlap."""
        return distance_to_body(model, state, self.x, self.y) - self.reach

    def to_shadow(self, other: Shadow) -> float:
        """Return the distance to the outline of another robot [m]; not positive if they overlap."""
        if len(other.corners) > 1:
            return distance_to_shadow(other.corners, self.shadow)
        x, y = other.corners[0].tolist()
        return math.hypot(self.x - x, self.y - y) - other.radius - self.reach


@dataclass(frozen=True)
class PlacedPolygon:
    """The footprint of a robot at a pose.

    Attributes:
        x, y: Origin of the base in `map` [m].
        reach: Distance of its farthest corner from there [m].
        corners: Its corners in `map`, counterclockwise, shape (n, 2) [m].
    """

    x: float
    y: float
    reach: float
    corners: Array

    @property
    def shadow(self) -> Shadow:
        """Its shape from above."""
        return Shadow(self.corners)

    def to_walls(self, walls: WallDistance, _: Clearance, within: float) -> Clearance:
        """Return the nearest wall that is nearer than `within` [m], with a distance of 0 if they overlap."""
        return walls.nearest_to_polygon(self, within)

    def to_body(self, model: BodyModel, state: BodyState) -> float:
        """Return the distance to a body [m]; 0 if they overlap."""
        return distance_from_polygon(self.corners, model, state)

    def to_shadow(self, other: Shadow) -> float:
        """Return the distance to the outline of another robot [m]; 0 if they overlap."""
        return distance_to_shadow(self.corners, other)


PlacedOutline = PlacedDisc | PlacedPolygon


@dataclass(frozen=True)
class Search:
    """A search for the nearest entity of a robot.

    Attributes:
        robot: Its name.
        pose: Its pose in `map`.
        within: Distance from which entities are left out [m]; the result has none if all are left out.
    """

    robot: str
    pose: Pose2
    within: float = math.inf


def placed_outline(base: MobileDeclaration, pose: Pose2) -> PlacedOutline:
    """Return the outline of a robot at a pose: its footprint, or its circle without one."""
    if base.footprint is None:
        return PlacedDisc(pose.x, pose.y, _reach_of(base))
    return PlacedPolygon(pose.x, pose.y, _reach_of(base), placed_corners(base.footprint, pose))


def _reach_of(base: MobileDeclaration) -> float:
    """Return the distance of the farthest point of a robot's outline from its origin [m]."""
    return base.radius if base.footprint is None else base.footprint.radius


class Clearances(Stateful):
    """Distances of the outlines of robots to other entities, from above.

    Args:
        engine: Engine with the present states.
        walls: Walls of the world.
        entities: Entities of the world.
        bases: Declarations of the robots that drive, by name.
    """

    DERIVED = ("_near_walls",)

    def __init__(
        self,
        engine: Engine,
        walls: Sequence[Wall],
        entities: Entities,
        bases: Mapping[str, MobileDeclaration],
    ) -> None:
        self._engine = engine
        self._entities = entities
        self._bases = bases
        self._reaches = {name: _reach_of(base) for name, base in bases.items()}
        self._walls = WallDistance(walls)
        self._near_walls: dict[str, NearWalls] = {}  # by robot
        self._walls_by_name = {
            name: WallDistance([wall for wall in walls if wall.name == name])
            for name in {wall.name for wall in walls}
        }

    @property
    def names(self) -> list[str]:
        """Names of the entities to which there is a distance."""
        return [*self._walls_by_name, *self._entities.bodies, *self._bases]

    def nearest(self, searches: Sequence[Search]) -> list[Clearance]:
        """Return for each search the nearest of all walls, bodies and other robots that drive; 0 m at least."""
        state = self._engine.body_state
        places = [(other, reach, *state(other).position[:2]) for other, reach in self._reaches.items()]
        return [self._nearest(search, places) for search in searches]

    def _nearest(self, search: Search, places: Sequence[tuple[str, float, float, float]]) -> Clearance:
        """Return the result of a search, by names, reaches and positions of all robots that drive [m]."""
        robot, pose, within = search.robot, search.pose, search.within
        wall = self._nearest_wall(robot, pose)
        has_walls = wall.distance - self._reaches[robot] < within
        robots = self._robots_within(robot, pose, within, places)
        bodies = self._bodies_within(robot, pose, within)
        if not (has_walls or robots or bodies):
            return Clearance()
        outline = placed_outline(self._bases[robot], pose)
        best = Clearance(within)
        if has_walls:
            best = min(best, outline.to_walls(self._walls, wall, within), key=_distance)
        for name, model in bodies:
            best = self._nearer(best, name, model, outline)
        for other in robots:
            best = self._nearer_robot(best, other, outline)
        return _at_least_zero(best) if best.entity else Clearance()

    def _robots_within(
        self, robot: str, pose: Pose2, within: float, places: Sequence[tuple[str, float, float, float]]
    ) -> list[str]:
        """Return the other robots that may be nearer than `within` [m], by both axes."""
        (x, y, _), own, found = pose, self._reaches[robot], []
        for other, reach, other_x, other_y in places:
            apart = within + reach + own
            if -apart < x - other_x < apart and -apart < y - other_y < apart and other != robot:
                found.append(other)
        return found

    def _bodies_within(self, robot: str, pose: Pose2, within: float) -> list[tuple[str, BodyModel]]:
        """Return the bodies whose spheres are nearer than `within` [m]."""
        (x, y, _), own, found = pose, self._reaches[robot], []
        for name, model in self._entities.bodies.items():
            other_x, other_y, _ = self._engine.body_state(name).position
            if math.hypot(x - other_x, y - other_y) - model.reach - own < within:
                found.append((name, model))
        return found

    def _nearest_wall(self, robot: str, pose: Pose2) -> Clearance:
        """Return the wall that is nearest to the origin of a robot."""
        x, y, _ = pose
        walls = self._near_walls.get(robot)
        if walls is None or not walls.covers(x, y):
            walls = self._near_walls[robot] = self._walls.near(x, y, AROUND)
        return Clearance(*walls.nearest(x, y))

    def between(self, robot: str, pose: Pose2, other: str) -> Clearance:
        """Return the distance to one entity, which is one of `names`; 0 m at least."""
        bodies, outline = self._entities.bodies, placed_outline(self._bases[robot], pose)
        if other in self._walls_by_name:
            walls = self._walls_by_name[other]
            distance = outline.to_walls(walls, walls.nearest(pose.x, pose.y), math.inf).distance
        elif other in bodies:
            distance = outline.to_body(bodies[other], self._engine.body_state(other))
        elif other in self._bases:
            distance = outline.to_shadow(self._shadow_of(other))
        else:
            return Clearance()  # deleted
        return _at_least_zero(Clearance(distance, other))

    def _nearer(self, best: Clearance, name: str, model: BodyModel, outline: PlacedOutline) -> Clearance:
        state = self._engine.body_state(name)
        x, y, _ = state.position
        if math.hypot(outline.x - x, outline.y - y) - model.reach - outline.reach >= best.distance:
            return best
        return min(best, Clearance(outline.to_body(model, state), name), key=_distance)

    def _shadow_of(self, robot: str) -> Shadow:
        return placed_outline(self._bases[robot], self._engine.body_state(robot).planar).shadow

    def _nearer_robot(self, best: Clearance, other: str, outline: PlacedOutline) -> Clearance:
        return min(best, Clearance(outline.to_shadow(self._shadow_of(other)), other), key=_distance)


def _at_least_zero(found: Clearance) -> Clearance:
    return Clearance(max(0.0, found.distance), found.entity)


def _distance(clearance: Clearance) -> float:
    return clearance.distance
