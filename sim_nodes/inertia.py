"""Distribution of mass in bodies: volumes, centres of mass, and inertia.

Masses are uniform in each part; parts have given masses, or shares by volume.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple, assert_never

import numpy as np

from seoro.deferred import dataclass
from sim_nodes.geometry import Array, Quaternion, Vector, quaternion_of, rotation_matrix, vector
from sim_nodes.physics import IDENTITY, BodyModel, Box, Capsule, Cylinder, Hull, Part, Shape, Sphere

SYMMETRIC = 1e-12  # products of inertia below this share of the largest moment are rounding errors


@dataclass(frozen=True)
class Inertia:
    """Centre of mass in the body's frame [m], principal moments [kg m^2], and orientation of their axes."""

    centre: Vector
    moments: Vector
    axes: Quaternion


class _Solid(NamedTuple):
    """A uniformly filled shape: volume [m^3], centroid, and inertia tensor about it, of 1 kg [m^2]."""

    volume: float
    centre: Array
    tensor: Array


def part_masses(model: BodyModel) -> tuple[float, ...]:
    """Return the masses of a body's parts [kg]."""
    own = [part.mass for part in model.parts if part.mass is not None]
    return tuple(own) if own else masses_by_volume(model.parts, model.mass)


def masses_by_volume(parts: Sequence[Part], mass: float) -> tuple[float, ...]:
    """Return the masses of parts that share a mass by volume [kg]."""
    volumes = [volume(part.shape) for part in parts]
    return tuple(mass * share / sum(volumes) for share in volumes)


def inertia(model: BodyModel) -> Inertia:
    """Compute the inertia of a body from its parts."""
    centre, tensor = inertia_tensor(model.parts, part_masses(model))
    return Inertia(vector(centre), *_principal(tensor))


def inertia_tensor(parts: Iterable[Part], masses: Sequence[float]) -> tuple[Array, Array]:
    """Compute the centre of mass of parts [m], and their inertia tensor about it [kg m^2].

    Args:
        parts: The parts.
        masses: Their masses [kg].

    Returns:
        Arrays of shape (3,) and (3, 3), in the frame of the parts.
    """
    turned = [(rotation_matrix(part.orientation), _solid(part.shape), part.position) for part in parts]
    positions = np.array([turn @ solid.centre + position for turn, solid, position in turned])
    centre = np.average(positions, axis=0, weights=masses)
    tensor = np.zeros((3, 3))
    for (turn, solid, _), mass, position in zip(turned, masses, positions, strict=True):
        arm = position - centre
        # The second term is the parallel axis theorem.
        tensor += mass * (turn @ solid.tensor @ turn.T)
        tensor += mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return centre, tensor


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
    return _solid(shape).volume


def _solid(shape: Shape) -> _Solid:
    match shape:
        case Box(size=(x, y, z)):
            return _centred(x * y * z, (y * y + z * z) / 12, (x * x + z * z) / 12, (x * x + y * y) / 12)
        case Cylinder(radius=radius, length=length):
            across = (3 * radius * radius + length * length) / 12
            return _centred(math.pi * radius * radius * length, across, across, radius * radius / 2)
        case Capsule(radius=radius, length=length):
            # A cylinder and two halves of a sphere, whose centroids are 3/8 of the radius from its ends.
            square, long = radius * radius, length * length
            middle, ends = length / (length + 4 / 3 * radius), 4 / 3 * radius / (length + 4 / 3 * radius)
            along = middle * square / 2 + ends * 0.4 * square
            across = middle * (3 * square + long) / 12 + ends * (0.4 * square + long / 4 + 3 / 8 * length * radius)
            return _centred(math.pi * square * (length + 4 / 3 * radius), across, across, along)
        case Sphere(radius=radius):
            return _centred(4.0 / 3.0 * math.pi * radius**3, *(3 * [0.4 * radius * radius]))
        case Hull():
            return _filled_hull(shape.points)
        case _:
            assert_never(shape)


def _centred(size: float, *moments: float) -> _Solid:
    return _Solid(size, np.zeros(3), np.diag(moments))


def _filled_hull(points: Array) -> _Solid:
    """Sum the tetrahedra between a point inside and the faces of a convex hull."""
    from scipy.spatial import ConvexHull  # noqa: PLC0415 - for meshes only

    hull, inside = ConvexHull(points), points.mean(axis=0)
    corners = points[hull.simplices] - inside
    sizes = np.abs(np.linalg.det(corners)) / 6
    size = float(sizes.sum())
    centre = (sizes[:, None] * corners.sum(axis=1)).sum(axis=0) / (4 * size)
    # Second moments of a tetrahedron with a corner at the origin, by the sums of its other corners.
    sums = corners.sum(axis=1)
    second = np.einsum("t,tci,tcj->ij", sizes, corners, corners) + np.einsum("t,ti,tj->ij", sizes, sums, sums)
    second = second / (20 * size) - np.outer(centre, centre)
    return _Solid(size, centre + inside, np.trace(second) * np.eye(3) - second)
