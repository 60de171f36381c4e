"""Wheels of a model, and the frame of its base: on the floor, at the centre of its motion."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from seoro.deferred import dataclass
from sim_nodes.extents import reach
from sim_nodes.geometry import Array, Vector, rotation_matrix, wrap
from sim_nodes.physics import Cylinder, Part, Sphere
from sim_nodes.robots.derive.model import ModelJoint, RobotModel
from sim_nodes.robots.drive_declaration import DriveKind

LEVEL = 0.1  # largest vertical component of a wheel's axis
UPRIGHT = 0.9  # smallest vertical component of an axis that steers
ROUNDNESS = 0.1  # largest relative difference of height and length of a wheel
FLOOR_GAP = 0.03  # [m] between the floor and the lowest point of a wheel
SMALLER = 0.8  # share of the largest radius below which a wheel is not driven
CROSSED = 0.3  # [rad] between wheels that roll in different directions
SAME = 1e-3  # [m], [rad] between equal places
ON_FLOOR = 2e-3  # [m] between the root and the floor


@dataclass(frozen=True)
class Wheel:
    """A wheel of a model, in the frame of the root.

    Attributes:
        joint: Joint that turns it.
        centre: Centre of its solid shapes [m].
        radius: Radius [m].
        width: Width along its axis [m].
        heading: Direction of rolling without steering, within 90 degrees of ahead [rad].
        turns_backwards: Whether a positive angle of the joint rolls back.
        steering: Nearest joint with a vertical axis that carries it.
        is_exact: Whether its shape is a cylinder or a sphere.
    """

    joint: ModelJoint
    centre: Vector
    radius: float
    width: float
    heading: float
    turns_backwards: bool
    steering: ModelJoint | None
    is_exact: bool

    @property
    def bottom(self) -> float:
        """Height of its lowest point [m]."""
        return self.centre[2] - self.radius


def find_wheels(model: RobotModel) -> tuple[Wheel, ...]:
    """Find the wheels: round links on the floor that turn freely about a horizontal axis."""
    found = [wheel for joint in model.joints.values() if (wheel := _wheel(model, joint)) is not None]
    if not found:
        return ()
    floor = min(wheel.bottom for wheel in found)
    return tuple(wheel for wheel in found if wheel.bottom - floor <= FLOOR_GAP)


def _wheel(model: RobotModel, joint: ModelJoint) -> Wheel | None:
    parts = [part for link in model.frames if model.carrier(link) == joint.child for part in model.solids[link]]
    if joint.kind != "continuous" or abs(joint.axis[2]) > LEVEL or not parts:
        return None
    measured = _measure(parts, joint.axis)
    if measured is None:
        return None
    centre, radius, width = measured
    away = np.subtract(centre, model.frames[joint.child][0])
    if math.hypot(*np.subtract(away, np.dot(away, joint.axis) * np.array(joint.axis))) > ROUNDNESS * radius:
        return None  # it does not turn about its own axis
    heading = math.atan2(-joint.axis[0], joint.axis[1])
    backwards = abs(heading) > math.pi / 2 + 1e-6
    steering = next((each for each in model.ancestors(joint.parent) if _steers(each)), None)
    is_exact = any(isinstance(part.shape, Cylinder | Sphere) for part in parts)
    return Wheel(
        joint,
        centre,
        radius,
        width,
        wrap(heading + math.pi) if backwards else heading,
        backwards,
        steering,
        is_exact,
    )


def wheel_place(model: RobotModel, link: str) -> tuple[float, float]:
    """Return where a wheel stands in the frame of the root [m]: at the middle of its width."""
    joint, (x, y, _) = model.joints[link], model.frames[link][0]
    wheel = _wheel(model, joint)
    return (x, y) if wheel is None else (wheel.centre[0], wheel.centre[1])


def _steers(joint: ModelJoint) -> bool:
    return joint.kind in ("revolute", "continuous") and abs(joint.axis[2]) >= UPRIGHT


def _measure(parts: Sequence[Part], axis: Vector) -> tuple[Vector, float, float] | None:
    """Return centre [m], radius [m] and width [m] of shapes around an axis; None if they are not round."""
    ahead = np.array([axis[1], -axis[0], 0.0]) / math.hypot(axis[0], axis[1])
    along = np.array(axis)
    (x_low, x_high), (y_low, y_high), (z_low, z_high) = (
        _span(parts, direction) for direction in (ahead, along, np.array([0.0, 0.0, 1.0]))
    )
    length, height = x_high - x_low, z_high - z_low
    if abs(length - height) > ROUNDNESS * max(length, height):
        return None
    x, y, z = ahead * (x_low + x_high) / 2 + along * (y_low + y_high) / 2 + np.array([0, 0, (z_low + z_high) / 2])
    radius = next((part.shape.radius for part in parts if isinstance(part.shape, Cylinder | Sphere)), height / 2)
    return (float(x), float(y), float(z)), radius, y_high - y_low


def _span(parts: Sequence[Part], direction: Array) -> tuple[float, float]:
    """Return how far shapes reach along a unit vector, from and to [m]."""
    return -farthest(parts, -direction), farthest(parts, direction)


def farthest(parts: Sequence[Part], direction: Array) -> float:
    """Return how far shapes reach along a unit vector [m]."""
    return max(_reach(part, direction) for part in parts)


def _reach(part: Part, direction: Array) -> float:
    turn = rotation_matrix(part.orientation)
    return float(np.dot(part.position, direction)) + reach(part.shape, turn.T @ direction)


def guess_kind(wheels: Sequence[Wheel]) -> DriveKind | None:
    """Return the kind of drive that wheels suggest; None for fewer than two."""
    rolling = driven_wheels(wheels)
    if any(_is_steering(wheel) for wheel in wheels) and len(wheels) > 2:
        return DriveKind.ACKERMANN
    if len(rolling) < 2:
        return None
    if max(wheel.heading for wheel in rolling) - min(wheel.heading for wheel in rolling) > CROSSED:
        return DriveKind.OMNIDIRECTIONAL
    return DriveKind.DIFFERENTIAL if len(rolling) == 2 else DriveKind.SKID_STEER


def _is_steering(wheel: Wheel) -> bool:
    """Whether a wheel is steered; the joint of a caster turns freely, and lies behind or ahead of its wheel."""
    if wheel.steering is None:
        return False
    return wheel.steering.kind == "revolute" or "steer" in wheel.steering.name.lower()


def driven_wheels(wheels: Sequence[Wheel]) -> tuple[Wheel, ...]:
    """Return the wheels that drive a robot which does not steer: the large ones without a vertical joint."""
    rolling = [wheel for wheel in wheels if wheel.steering is None]
    largest = max((wheel.radius for wheel in rolling), default=0.0)
    return tuple(wheel for wheel in rolling if wheel.radius >= SMALLER * largest)


@dataclass(frozen=True)
class BaseFrame:
    """The frame of a base in that of the root of its model: on the floor, ahead along x [m, rad]."""

    x: float
    y: float
    floor: float
    yaw: float

    @property
    def is_root(self) -> bool:
        """Whether it is the frame of the root."""
        return max(map(abs, (self.x, self.y, self.yaw))) <= SAME and abs(self.floor) <= ON_FLOOR

    def place(self, point: Vector) -> tuple[float, float]:
        """Return a point of the root's frame in that of the base, seen from above [m]."""
        dx, dy, cos, sin = point[0] - self.x, point[1] - self.y, math.cos(self.yaw), math.sin(self.yaw)
        return cos * dx + sin * dy, cos * dy - sin * dx


def base_frame(kind: DriveKind, wheels: Sequence[Wheel]) -> BaseFrame:
    """Return the frame of a base: between its wheels, or between the rear wheels of an Ackermann drive."""
    rear = [wheel for wheel in wheels if wheel.steering is None]
    at = rear if kind is DriveKind.ACKERMANN and rear else list(wheels)
    yaw = 0.0 if kind is DriveKind.OMNIDIRECTIONAL else float(np.mean([wheel.heading for wheel in at]))
    x, y = (float(np.mean([wheel.centre[axis] for wheel in at])) for axis in (0, 1))
    return BaseFrame(x, y, float(np.mean([wheel.bottom for wheel in at])), yaw if abs(yaw) > SAME else 0.0)
