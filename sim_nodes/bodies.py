"""Shapes, bodies and their states. Units are SI; orientations are quaternions (w, x, y, z)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cached_property
from typing import assert_never

import numpy as np

from seoro.deferred import dataclass
from sim_nodes.geometry import (
    Array,
    Frame,
    Pose2,
    Quaternion,
    Vector,
    multiply,
    quaternion,
    rotated,
    vector,
    yaw_of,
)
from sim_nodes.views import Colour

IDENTITY: Quaternion = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Box:
    """A box by its edge lengths [m]."""

    size: Vector


@dataclass(frozen=True)
class Cylinder:
    """A cylinder along its z axis [m]."""

    radius: float
    length: float


@dataclass(frozen=True)
class Sphere:
    """A sphere [m]."""

    radius: float


@dataclass(frozen=True)
class Capsule:
    """A cylinder along its z axis with half a sphere at each end; `length` is that of the cylinder [m]."""

    radius: float
    length: float


@dataclass(frozen=True)
class Hull:
    """The convex hull of points, given as little-endian doubles: x, y, z of one point after the other [m]."""

    data: bytes

    @property
    def points(self) -> Array:
        """The points, shape (n, 3) [m]."""
        return np.frombuffer(self.data, "<f8").reshape(-1, 3)


Shape = Box | Cylinder | Sphere | Capsule | Hull


@dataclass(frozen=True)
class Part:
    """A shape at a pose in its body's frame; without `mass` [kg], it has a share of the body's mass by volume."""

    shape: Shape
    position: Vector = (0.0, 0.0, 0.0)
    orientation: Quaternion = IDENTITY
    mass: float | None = None

    def placed(self, position: Vector, orientation: Quaternion) -> Part:
        """Return the part in the parent frame of its body, which has this pose there."""
        centre = vector(np.add(position, rotated(orientation, self.position)))
        return Part(self.shape, centre, multiply(orientation, self.orientation), self.mass)


@dataclass(frozen=True)
class Urdf:
    """A model file for the loaders of engines, in the form that all of them read alike (`models/canonical.py`).

    Attributes:
        text: Its text.
        meshes: Meshes by file name: in STL, or in OBJ with a picture in PNG.
        joints: Names of movable joints, in the order of the file.
        friction: Coefficients of sliding friction by link; others have that of the body.
    """

    text: str
    meshes: Mapping[str, bytes]
    joints: tuple[str, ...]
    friction: Mapping[str, float]


@dataclass(frozen=True)
class Mjcf:
    """A model file for MuJoCo: its text, and its assets by file name."""

    text: str
    assets: Mapping[str, bytes]


@dataclass(frozen=True)
class BodyModel:
    """A body: parts, mass [kg], and coefficient of sliding friction of its surface.

    All parts have a `mass`, or none has. Each engine combines the friction of two surfaces in its own way. A body
    from a file has it in `urdf`, and perhaps in MuJoCo's format in `mjcf`; engines load the file. It may have
    joints, and `parts` are its solid shapes with all joints at zero. `notes` list parts without effect.
    """

    parts: tuple[Part, ...]
    mass: float = 1.0
    friction: float = 1.0
    static: bool = False  # not moved by forces; `set_body_state` still moves it
    driven: bool = False  # moves upright by `DrivesBodies.drive_bodies`; never static
    built_in: bool = False  # a driven part of the building: without weight; passes through walls and the floor
    yields: bool = False  # a driven body whose mass alone limits the impulses that it gives
    colour: Colour | None = None  # in rendered pictures; None to derive it from the name
    urdf: Urdf | None = None
    mjcf: Mjcf | None = None
    notes: tuple[str, ...] = ()

    @cached_property
    def reach(self) -> float:
        """Radius of a sphere around its origin that contains all parts [m]."""
        return max((math.hypot(*part.position) + _radius(part.shape) for part in self.parts), default=0.0)


def _radius(shape: Shape) -> float:
    """Return the radius of a sphere around the origin of a shape that contains it [m]."""
    match shape:
        case Box(size=size):
            return math.hypot(*size) / 2
        case Cylinder(radius=radius, length=length):
            return math.hypot(radius, length / 2)
        case Sphere(radius=radius):
            return radius
        case Capsule(radius=radius, length=length):
            return radius + length / 2
        case Hull():
            return float(np.linalg.norm(shape.points, axis=1).max())
        case _:
            assert_never(shape)


@dataclass(frozen=True)
class BodyState:
    """Pose in `map` [m], and linear [m/s] and angular [rad/s] velocity of the origin, in the axes of `map`."""

    position: Vector
    orientation: Quaternion = IDENTITY
    linear: Vector = (0.0, 0.0, 0.0)
    angular: Vector = (0.0, 0.0, 0.0)

    @property
    def frame(self) -> Frame:
        """The pose as a frame in `map`."""
        return self.position, self.orientation

    @property
    def planar(self) -> Pose2:
        """The pose projected onto the floor."""
        return Pose2(self.position[0], self.position[1], yaw_of(self.orientation))


@dataclass(frozen=True)
class Wall:
    """A box; walls of the same name are one entity."""

    name: str
    x: float  # centre [m]
    y: float
    yaw: float
    length: float  # along its own x [m]
    thickness: float
    height: float
    z: float = 0.0  # of its lower side [m]

    @property
    def part(self) -> Part:
        """The wall as a part of a body at the origin of `map`."""
        size = (self.length, self.thickness, self.height)
        return Part(Box(size), (self.x, self.y, self.z + self.height / 2), quaternion(0.0, 0.0, self.yaw))
