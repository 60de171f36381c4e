"""Distances on the floor from points to walls, bodies and robots, of the true world, seen from above."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import assert_never

import numpy as np

from sim_nodes.entities import Entities
from sim_nodes.geometry import Array, Pose2, rotation_matrix
from sim_nodes.physics import BodyModel, BodyState, Box, Cylinder, Engine, Part, Sphere, Wall


class WallDistance:
    """Distances to the nearest of a set of walls."""

    def __init__(self, walls: Sequence[Wall]) -> None:
        self._centre = np.array([(wall.x, wall.y) for wall in walls]).reshape(-1, 2)
        self._half = np.array([(wall.length / 2, wall.thickness / 2) for wall in walls]).reshape(-1, 2)
        yaw = np.array([wall.yaw for wall in walls])
        self._cos, self._sin = np.cos(yaw), np.sin(yaw)

    def at(self, x: float, y: float) -> float:
        """Return the distance of a point [m]; 0 inside a wall, infinite without walls."""
        dx, dy = x - self._centre[:, 0], y - self._centre[:, 1]
        along = np.abs(self._cos * dx + self._sin * dy) - self._half[:, 0]
        across = np.abs(self._cos * dy - self._sin * dx) - self._half[:, 1]
        return float(np.hypot(along.clip(0.0), across.clip(0.0)).min(initial=np.inf))


class Surroundings:
    """Obstacles of wheeled robots: walls, spawned bodies, and other robots.

    Args:
        engine: Engine with the present states.
        walls: Walls of the world.
        entities: Spawned bodies.
        radii: Radii of the wheeled robots by name [m].
    """

    def __init__(
        self, engine: Engine, walls: Sequence[Wall], entities: Entities, radii: Mapping[str, float]
    ) -> None:
        self._engine = engine
        self._walls = WallDistance(walls)
        self._entities = entities
        self._radii = radii

    def clearance(self, robot: str, pose: Pose2) -> float:
        """Return the distance from a robot's circle at a pose to the nearest obstacle [m]; 0 at least."""
        distances = [self._walls.at(pose.x, pose.y)]
        for name, spawned in self._entities.spawned.items():
            distances.append(distance_to_body(spawned.model, self._engine.body_state(name), pose.x, pose.y))
        for other, radius in self._radii.items():
            if other != robot:
                there = self._engine.body_state(other).planar
                distances.append(pose.distance(there.x, there.y) - radius)
        return max(0.0, min(distances) - self._radii[robot])


def distance_to_body(model: BodyModel, state: BodyState, x: float, y: float) -> float:
    """Return the distance of a point to a body [m]; 0 inside. Parts at all heights count."""
    body = rotation_matrix(state.orientation)
    return min(_distance_to_part(part, body, np.array(state.position), x, y) for part in model.parts)


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
        case _:
            assert_never(part.shape)
