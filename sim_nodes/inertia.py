"""Mass distribution of bodies: uniform in each part; parts have given masses, or shares by volume."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import assert_never

import numpy as np

from sim_nodes.geometry import Array, Quaternion, Vector, quaternion_of, rotation_matrix, vector
from sim_nodes.physics import IDENTITY, BodyModel, Box, Cylinder, Shape, Sphere

SYMMETRIC = 1e-12  # products of inertia below this share of the largest moment are rounding errors


@dataclass(frozen=True)
class Inertia:
    """Centre of mass in the body's frame [m], principal moments [kg m^2], and orientation of their axes."""

    centre: Vector
    moments: Vector
    axes: Quaternion


def part_masses(model: BodyModel) -> tuple[float, ...]:
    """Return the masses of a body's parts [kg]."""
    own = [part.mass for part in model.parts if part.mass is not None]
    if own:
        return tuple(own)
    volumes = [volume(part.shape) for part in model.parts]
    return tuple(model.mass * share / sum(volumes) for share in volumes)


def inertia(model: BodyModel) -> Inertia:
    """Compute the inertia of a body."""
    masses = part_masses(model)
    positions = np.array([part.position for part in model.parts])
    centre = np.average(positions, axis=0, weights=masses)
    tensor = np.zeros((3, 3))
    for part, mass, position in zip(model.parts, masses, positions, strict=True):
        turn = rotation_matrix(part.orientation)
        arm = position - centre
        # The second term is the parallel axis theorem.
        tensor += turn @ np.diag(_moments(part.shape, mass)) @ turn.T
        tensor += mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return Inertia(vector(centre), *_principal(tensor))


def _principal(tensor: Array) -> tuple[Vector, Quaternion]:
    """Return principal moments and axes; the body's own axes if they are principal."""
    diagonal = np.diag(tensor)
    if np.abs(tensor - np.diag(diagonal)).max() <= SYMMETRIC * diagonal.max():
        return vector(diagonal), IDENTITY
    moments, axes = np.linalg.eigh(tensor)
    if np.linalg.det(axes) < 0:
        axes[:, 0] *= -1.0
    return vector(moments), quaternion_of(axes)


def volume(shape: Shape) -> float:
    """Return the volume of a shape [m^3]."""
    match shape:
        case Box(size=(x, y, z)):
            return x * y * z
        case Cylinder(radius=radius, length=length):
            return math.pi * radius * radius * length
        case Sphere(radius=radius):
            return 4.0 / 3.0 * math.pi * radius**3
        case _:
            assert_never(shape)


def _moments(shape: Shape, mass: float) -> Vector:
    """Return the moments of inertia about the centre of a shape [kg m^2]."""
    match shape:
        case Box(size=(x, y, z)):
            return mass * (y * y + z * z) / 12, mass * (x * x + z * z) / 12, mass * (x * x + y * y) / 12
        case Cylinder(radius=radius, length=length):
            across = mass * (3 * radius * radius + length * length) / 12
            return across, across, mass * radius * radius / 2
        case Sphere(radius=radius):
            moment = 0.4 * mass * radius * radius
            return moment, moment, moment
        case _:
            assert_never(shape)
