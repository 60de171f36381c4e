"""Doors and lifts: their bodies, and the poses of these by the position of the part (`travel.py`)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from seoro.deferred import dataclass
from sim_nodes.buildings.schema import AutomaticFile, DoorFile, LiftFile
from sim_nodes.buildings.travel import Limits
from sim_nodes.geometry import Pose2, quaternion, wrap
from sim_nodes.physics import BodyModel, BodyState, Box, Part
from sim_nodes.terrain.ground import FLAT, Ground
from sim_nodes.ticks import TICK
from sim_nodes.views import Colour

GAP = 0.01  # [m] beside a leaf, and below it
SUNK = 0.001  # [m] below the floor, of a lift at the height 0: robots do not touch its edges there
LEAF_MASS, LIFT_MASS = 100.0, 2000.0  # [kg]
SAMPLES = 21  # points of the ground below a door
ACCELERATION = 1.0  # [m/s^2] of the edge of a leaf, and of a lift
FRICTION = 1.0

Point = tuple[float, float]  # [m]


class Place(NamedTuple):
    """Pose of a body: x, y and z of its origin [m], and yaw [rad]."""

    x: float
    y: float
    z: float
    yaw: float


@dataclass(frozen=True)
class Leaf:
    """A leaf of a door. Its origin is in the middle of its lower edge.

    Attributes:
        name: Name of the entity.
        model: Its body.
        closed: Its pose when the door is closed.
        height: Height of its lower edge [m].
        hinge: Point that a hinged leaf turns about [m]; None for a sliding one.
        angle: Angle when it is open [rad], if it is hinged.
        way: Way when it is open [m], if it slides.
    """

    name: str
    model: BodyModel
    closed: Pose2
    height: float
    hinge: Point | None
    angle: float
    way: Point

    def place(self, opening: float) -> Place:
        """Return the pose at an opening."""
        at = self.closed
        if self.hinge is None:
            return Place(at.x + opening * self.way[0], at.y + opening * self.way[1], self.height, at.yaw)
        turn = opening * self.angle
        (x, y), cos, sin = self.hinge, math.cos(turn), math.sin(turn)
        dx, dy = at.x - x, at.y - y
        return Place(x + cos * dx - sin * dy, y + sin * dx + cos * dy, self.height, at.yaw + turn)

    def opening(self, state: BodyState) -> float:
        """Return the opening at a state of the body."""
        here = state.planar
        if self.hinge is not None:
            return float(wrap(here.yaw - self.closed.yaw)) / self.angle
        (x, y), at = self.way, self.closed
        return ((here.x - at.x) * x + (here.y - at.y) * y) / (x * x + y * y)


@dataclass(frozen=True)
class Door:
    """A door of a world; its position is its opening, from 0 to 1."""

    name: str
    leaves: tuple[Leaf, ...]
    middle: Point
    limits: Limits
    start: float = 0.0
    locked: bool = False
    automatic: AutomaticFile | None = None
    tags: tuple[str, ...] = ()

    kind = "door"

    @property
    def bodies(self) -> tuple[tuple[str, BodyModel], ...]:
        """Names and models of its bodies."""
        return tuple((leaf.name, leaf.model) for leaf in self.leaves)

    def places(self, position: float) -> tuple[Place, ...]:
        """Return the poses of its bodies."""
        return tuple(leaf.place(position) for leaf in self.leaves)

    def position(self, states: Sequence[BodyState]) -> float:
        """Return the position by the states of its bodies."""
        found = [leaf.opening(state) for leaf, state in zip(self.leaves, states, strict=True)]
        return min(max(sum(found) / len(found), 0.0), 1.0)

    def describe(self, position: float) -> str:
        """Describe a position."""
        return f"{100.0 * position:.0f} % open"


@dataclass(frozen=True)
class Lift:
    """A lift of a world; its position is the height of its surface [m], and the origin of its body is there."""

    name: str
    model: BodyModel
    pose: Pose2
    floors: tuple[float, ...]
    limits: Limits
    start: float
    tags: tuple[str, ...] = ()

    kind = "lift"

    @property
    def bodies(self) -> tuple[tuple[str, BodyModel], ...]:
        """Names and models of its bodies."""
        return ((self.name, self.model),)

    def places(self, position: float) -> tuple[Place, ...]:
        """Return the poses of its bodies."""
        return (Place(self.pose.x, self.pose.y, position, self.pose.yaw),)

    def position(self, states: Sequence[BodyState]) -> float:
        """Return the position by the states of its bodies."""
        return min(max(states[0].position[2], self.floors[0]), self.floors[-1])

    def describe(self, position: float) -> str:
        """Describe a position."""
        return f"at a height of {position:.2f} m"


BuildingPart = Door | Lift


def initial_state(place: Place) -> BodyState:
    """Return the state at rest at a pose."""
    return BodyState((place.x, place.y, place.z), quaternion(0.0, 0.0, place.yaw))


def make_door(file: DoorFile, wall_height: float, ground: Ground = FLAT) -> Door:
    """Return the door of an entry of a world file, on the ground.

    Args:
        file: The entry.
        wall_height: Height of a door by default [m].
        ground: The ground of the world.
    """
    at = Pose2(file.pose.x, file.pose.y, file.pose.yaw)
    floor = _highest_in_opening(file, at, ground) if file.z is None else file.z
    width = file.width / file.leaves - GAP
    size = (file.thickness, width, file.height or wall_height)
    model = BodyModel(
        (Part(Box(size), (0.0, 0.0, size[2] / 2.0)),),
        LEAF_MASS if file.force is None else file.force * TICK / file.speed,
        FRICTION,
        driven=True,
        built_in=True,
        yields=file.force is not None,
        colour=_paint(file.colour),
    )
    sides = (1.0, -1.0) if file.leaves == 2 else (-1.0 if file.side == "right" else 1.0,)
    leaves = tuple(
        _leaf(file, name, side, at, floor, model, width) for name, side in zip(file.bodies, sides, strict=True)
    )
    [leaf, *_] = leaves
    edge = abs(leaf.angle) * width if leaf.hinge is not None else math.hypot(*leaf.way)
    limits = Limits(file.speed / edge, ACCELERATION / edge)
    return Door(file.name, leaves, (at.x, at.y), limits, file.opening, file.locked, file.automatic, file.tags)


def _highest_in_opening(file: DoorFile, at: Pose2, ground: Ground) -> float:
    """Return the greatest height of the ground below a closed door [m]."""
    across = [at.compose(Pose2(0.0, y, 0.0)) for y in np.linspace(-file.width / 2.0, file.width / 2.0, SAMPLES)]
    return max(ground.height(point.x, point.y) for point in across)


def _leaf(file: DoorFile, name: str, side: float, at: Pose2, floor: float, model: BodyModel, width: float) -> Leaf:
    """Return a leaf at the left (1.0) or right (-1.0) side, which it is hinged to or slides to."""
    middle = side * (file.width - width) / 2.0
    closed = at.compose(Pose2(0.0, middle, 0.0))
    if file.kind == "sliding":
        way = file.way or width
        open_ = at.compose(Pose2(0.0, middle + side * way, 0.0))
        return Leaf(name, model, closed, floor + GAP, None, 0.0, (open_.x - closed.x, open_.y - closed.y))
    hinge = at.compose(Pose2(0.0, side * file.width / 2.0, 0.0))
    angle = side * (math.pi / 2.0 if file.angle is None else file.angle)
    return Leaf(name, model, closed, floor + GAP, (hinge.x, hinge.y), angle, (0.0, 0.0))


def make_lift(file: LiftFile, ground: Ground = FLAT) -> Lift:
    """Return the lift of an entry of a world file, whose floors are above the ground."""
    size = (*file.size, file.thickness)
    part = Part(Box(size), (0.0, 0.0, -file.thickness / 2.0))
    model = BodyModel((part,), LIFT_MASS, FRICTION, driven=True, built_in=True, colour=_paint(file.colour))
    pose = Pose2(file.pose.x, file.pose.y, file.pose.yaw)
    base = ground.height(pose.x, pose.y)
    floors = tuple(base + (height if height > 0.0 else -SUNK) for height in file.floors)
    limits = Limits(file.speed, ACCELERATION, floors[-1] - floors[0])
    return Lift(file.name, model, pose, floors, limits, floors[file.start], file.tags)


def _paint(colour: tuple[float, float, float] | None) -> Colour | None:
    return None if colour is None else (*colour, 1.0)
