"""A simulator in one file: no physics, only geometry, by numpy. `docs/how-to/simulators.md` walks through it.

Robots are discs that move as their wheels turn, and stop at obstacles. Spawned bodies stay at their poses.
Everything is upright: a shape is a rectangle or a circle in the plane, between two heights.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any

import numpy as np

from sim_nodes.geometry import Array, Pose2, Vector, quaternion, yaw_of
from sim_nodes.physics import (
    MAX_OVERLAP,
    BodyModel,
    BodyState,
    Box,
    ContactPoint,
    Cylinder,
    PlacedRobot,
    Scene,
    Sphere,
)
from sim_nodes.robots.kinematics import base_motion, per_motor, wheel_joints
from sim_nodes.unsupported import WithoutArms, WithoutDynamics, WithoutRendering, WithoutTerrain

STEPS_PER_SECOND = 100
ROBOT_HEIGHT = 0.35  # [m]
BODY_HEIGHT = 0.05  # [m] at which robots touch things
SEEN = 0.145  # [m], radius of a TurtleBot at the height of its lidar
LIDAR_HEIGHT = 0.193  # [m]
ALL_ROUND = np.linspace(-math.pi, math.pi, 360, endpoint=False)  # [rad]
PARALLEL = 1e-12  # cosine of an angle at which a ray is parallel to a side


@dataclass(frozen=True)
class Rectangle:
    """An upright box: its centre, heading, half edges, and the heights of its ends [m]."""

    pose: Pose2
    half: tuple[float, float]
    bottom: float
    top: float

    def distance(self, x: float, y: float) -> float:
        """Return the distance of a point to the border; negative inside [m]."""
        u, v, _ = self.pose.inverse().compose(Pose2(x, y, 0.0))
        outside = (abs(u) - self.half[0], abs(v) - self.half[1])
        return math.hypot(max(outside[0], 0.0), max(outside[1], 0.0)) + min(max(outside), 0.0)

    def rays(self, origin: Pose2, angles: Array) -> Array:
        """Return the distances along rays from a point, infinite without a hit [m]."""
        u, v, yaw = self.pose.inverse().compose(origin)
        near, far = np.full(angles.shape, -np.inf), np.full(angles.shape, np.inf)
        for place, direction, half in (
            (u, np.cos(angles + yaw), self.half[0]),
            (v, np.sin(angles + yaw), self.half[1]),
        ):
            slope = np.where(np.abs(direction) < PARALLEL, PARALLEL, direction)
            ends = np.sort([(-half - place) / slope, (half - place) / slope], axis=0)
            near, far = np.maximum(near, ends[0]), np.minimum(far, ends[1])
        return np.where((far >= near) & (far > 0.0), near.clip(0.0), np.inf)


@dataclass(frozen=True)
class Disc:
    """An upright cylinder: its centre, radius, and the heights of its ends [m]."""

    pose: Pose2
    radius: float
    bottom: float
    top: float

    def distance(self, x: float, y: float) -> float:
        """See `Rectangle.distance`."""
        return self.pose.distance(x, y) - self.radius

    def rays(self, origin: Pose2, angles: Array) -> Array:
        """See `Rectangle.rays`."""
        x, y = self.pose.x - origin.x, self.pose.y - origin.y
        along = x * np.cos(angles + origin.yaw) + y * np.sin(angles + origin.yaw)
        room = self.radius**2 - (x * x + y * y - along**2)
        near = along - np.sqrt(room.clip(0.0))
        return np.where((room > 0.0) & (near > 0.0), near, np.inf)


Solid = Rectangle | Disc


def solids(model: BodyModel, state: BodyState, height: float | None = None) -> Iterator[Solid]:
    """Yield the solids of a body, or those at a height."""
    for part in model.parts:
        pose = state.planar.compose(Pose2(part.position[0], part.position[1], yaw_of(part.orientation)))
        middle = state.position[2] + part.position[2]
        match part.shape:
            case Box(size=(length, width, tall)):
                yield Rectangle(pose, (length / 2, width / 2), middle - tall / 2, middle + tall / 2)
            case Cylinder(radius=radius, length=tall):
                yield Disc(pose, radius, middle - tall / 2, middle + tall / 2)
            case Sphere(radius=radius):
                off = 0.0 if height is None else min(abs(height - middle), radius)
                yield Disc(pose, math.sqrt(radius**2 - off**2), middle - radius, middle + radius)


def gap(one: Solid, other: Solid) -> float:
    """Return the distance of two solids; negative if they overlap [m]."""
    above = max(one.bottom - other.top, other.bottom - one.top)
    if isinstance(one, Disc):
        return max(above, other.distance(one.pose.x, one.pose.y) - one.radius)
    if isinstance(other, Disc):
        return max(above, one.distance(other.pose.x, other.pose.y) - other.radius)
    return max(above, _beside(one, other), _beside(other, one))


def _beside(one: Rectangle, other: Rectangle) -> float:
    """Return the distance of the corners of a rectangle beyond the sides of another (separating axes) [m]."""
    corners = [
        one.pose.inverse().compose(other.pose.compose(Pose2(u * other.half[0], v * other.half[1], 0.0)))
        for u in (-1, 1)
        for v in (-1, 1)
    ]
    return max(
        max(min(c[axis] for c in corners), -max(c[axis] for c in corners)) - one.half[axis] for axis in (0, 1)
    )


@dataclass(frozen=True)
class Rover:
    """Pose of a robot, and state of its wheels."""

    state: BodyState
    angles: tuple[float, ...]  # of its motors [rad]
    speeds: tuple[float, ...]  # commanded [rad/s]; angles of steering joints [rad]
    power: bool = True


class ToyEngine(WithoutDynamics, WithoutArms, WithoutRendering, WithoutTerrain):
    """Geometry instead of physics; see `sim_nodes.physics.Engine` for the methods."""

    name = "toy"
    version = "1"
    steps_per_second = STEPS_PER_SECOND

    def build(self, scene: Scene) -> None:
        """See `Engine.build`."""
        self._placed: dict[str, PlacedRobot] = {robot.name: robot for robot in scene.robots}
        self._walls: dict[str, list[Solid]] = {}
        for wall in scene.walls:
            pose, half = Pose2(wall.x, wall.y, wall.yaw), (wall.length / 2, wall.thickness / 2)
            self._walls.setdefault(wall.name, []).append(Rectangle(pose, half, 0.0, wall.height))
        self._models: dict[str, BodyModel] = {}
        self._first: dict[str, BodyState] = {}
        self.reset()

    def reset(self) -> None:
        """See `Engine.reset`."""
        self._robots = {
            name: self._at_rest(
                name, BodyState((robot.pose.x, robot.pose.y, 0.0), quaternion(0.0, 0.0, robot.pose.yaw))
            )
            for name, robot in self._placed.items()
        }
        self._bodies = dict(self._first)
        self._touching: frozenset[tuple[str, str]] = frozenset()

    def _at_rest(self, name: str, state: BodyState) -> Rover:
        mobile = self._mobile(name)
        still = () if mobile is None else per_motor(mobile.drive, 0.0, 0.0, 0.0)
        return Rover(state, still, still)

    def save(self) -> Mapping[str, Any]:
        """See `SavesState.save`."""
        robots = {
            name: (rover.state, rover.angles, rover.speeds, rover.power) for name, rover in self._robots.items()
        }
        return {
            "models": self._models,
            "first": self._first,
            "bodies": self._bodies,
            "robots": robots,
            "touching": self._touching,
        }

    def restore(self, saved: Mapping[str, Any]) -> None:
        """See `SavesState.restore`."""
        self._models, self._first, self._bodies = saved["models"], saved["first"], saved["bodies"]
        self._robots = {name: Rover(*parts) for name, parts in saved["robots"].items()}
        self._touching = saved["touching"]

    def step(self, count: int = 1) -> int:
        """See `Engine.step`."""
        for made in range(1, count + 1):
            before, self._touching = self._touching, frozenset().union(*map(self._drive_on, self._robots))
            if self._touching != before:
                return made
        return count

    def _drive_on(self, name: str) -> set[tuple[str, str]]:
        """Move a robot as its wheels turn in a step; returns the pairs with obstacles that it touches."""
        rover, drive = self._robots[name], self._mobile(name).drive
        wheels = len(wheel_joints(drive))
        turned = tuple(speed / STEPS_PER_SECOND if rover.power else 0.0 for speed in rover.speeds[:wheels])
        way, turn, aside = base_motion(drive, (*turned, *rover.speeds[wheels:]))
        cos, sin = math.cos(turn / 2), math.sin(turn / 2)
        x, y, yaw = rover.state.planar.compose(Pose2(way * cos - aside * sin, way * sin + aside * cos, turn))
        speed, side = way * STEPS_PER_SECOND, aside * STEPS_PER_SECOND
        moved = BodyState(
            (x, y, 0.0),
            quaternion(0.0, 0.0, yaw),
            (speed * math.cos(yaw) - side * math.sin(yaw), speed * math.sin(yaw) + side * math.cos(yaw), 0.0),
            (0.0, 0.0, turn * STEPS_PER_SECOND),
        )
        blocked = [other for other, room in self._gaps(name, [self._disc(name, moved)]) if room <= 0.0]
        if blocked:
            moved = BodyState(rover.state.position, rover.state.orientation)
        rolled = tuple(angle + way for angle, way in zip(rover.angles[:wheels], turned, strict=True))
        angles = (*rolled, *rover.speeds[wheels:])
        self._robots[name] = replace(rover, state=moved, angles=angles)
        return {(min(name, other), max(name, other)) for other in blocked}

    def touching(self) -> frozenset[tuple[str, str]]:
        """See `Engine.touching`."""
        return self._touching

    def contact_points(self, name: str) -> tuple[ContactPoint, ...]:
        """See `Engine.contact_points`; each is the nearest point of the other. Bodies do not move."""
        if name not in self._robots:
            return ()
        others = {other for pair in self._touching if name in pair for other in pair} - {name}
        return tuple(self._nearest(name, other) for other in sorted(others))

    def _nearest(self, robot: str, other: str) -> ContactPoint:
        """Return the point of an entity that is nearest to a robot's centre."""
        origin = self._robots[robot].state.planar
        ranges = np.array([solid.rays(origin, ALL_ROUND) for solid in self._solids(other)]).min(axis=0)
        nearest = int(ranges.argmin())
        towards = origin.compose(Pose2(0.0, 0.0, ALL_ROUND[nearest]))
        x, y, yaw = towards.compose(Pose2(ranges[nearest], 0.0, 0.0))
        return ContactPoint(other, (x, y, BODY_HEIGHT), (math.cos(yaw), math.sin(yaw), 0.0))

    def overlaps(self, name: str) -> tuple[str, ...]:
        """See `Engine.overlaps`."""
        return tuple(
            sorted({other for other, room in self._gaps(name, list(self._solids(name))) if room < -MAX_OVERLAP})
        )

    def add_body(self, name: str, model: BodyModel, state: BodyState) -> None:
        """See `Engine.add_body`."""
        self._models = {**self._models, name: model}
        self._first = {**self._first, name: state}
        self._bodies = {**self._bodies, name: state}

    def remove_body(self, name: str) -> None:
        """See `Engine.remove_body`."""
        for table in ("_models", "_first", "_bodies"):
            setattr(self, table, {other: each for other, each in getattr(self, table).items() if other != name})

    def body_state(self, name: str) -> BodyState:
        """See `Engine.body_state`."""
        return self._robots[name].state if name in self._robots else self._bodies[name]

    def set_body_state(self, name: str, state: BodyState) -> None:
        """See `Engine.set_body_state`."""
        if name in self._robots:
            self._robots[name] = replace(self._robots[name], state=state)
        else:
            self._bodies = {**self._bodies, name: state}

    def wheel_angles(self, robot: str) -> tuple[float, ...]:
        """See `Engine.wheel_angles`."""
        return self._robots[robot].angles

    def command_wheels(self, robot: str, *targets: float) -> None:
        """See `Engine.command_wheels`."""
        self._robots[robot] = replace(self._robots[robot], speeds=targets)

    def power_wheels(self, robot: str, on: bool) -> None:
        """See `Engine.power_wheels`."""
        self._robots[robot] = replace(self._robots[robot], power=on)

    def cast_rays(
        self, robot: str, link: str, directions: Array, limit: float, position: Vector = (0.0, 0.0, 0.0)
    ) -> Array:
        """See `Engine.cast_rays`; all rays are those of the lidar."""
        lidar = self._mobile(robot).lidar
        origin = self._robots[robot].state.planar.compose(Pose2(lidar.x, lidar.y, lidar.yaw))
        angles = np.arctan2(directions[:, 1], directions[:, 0])
        ranges = np.full(len(angles), np.inf)
        for name in chain(self._walls, self._models, self._robots):
            if name != robot:
                for solid in self._solids(name, LIDAR_HEIGHT):
                    if solid.bottom <= LIDAR_HEIGHT <= solid.top:
                        ranges = np.minimum(ranges, solid.rays(origin, angles))
        ranges[ranges > limit] = np.inf
        return ranges

    def _mobile(self, robot: str) -> Any:
        return self._placed[robot].declaration.mobile

    def _disc(self, robot: str, state: BodyState, radius: float | None = None) -> Disc:
        return Disc(state.planar, radius or self._mobile(robot).radius, 0.0, ROBOT_HEIGHT)

    def _solids(self, name: str, height: float | None = None) -> Iterable[Solid]:
        """Return the solids of an entity, or those at a height."""
        if name in self._walls:
            return self._walls[name]
        if name in self._robots:
            return [self._disc(name, self._robots[name].state, None if height is None else SEEN)]
        return solids(self._models[name], self._bodies[name], height)

    def _gaps(self, name: str, own: list[Solid]) -> Iterator[tuple[str, float]]:
        """Yield the distances of all other entities from the solids of an entity [m]."""
        for other in chain(self._walls, self._models, self._robots):
            if other != name:
                theirs = self._solids(other)
                yield other, min(gap(mine, solid) for solid in theirs for mine in own)
