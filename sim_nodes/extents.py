"""Sizes of bodies: outlines on the floor, lowest points, volumes, and mass distribution.

Outlines are seen from above. Masses are uniform in each part; parts have given masses, or shares by volume.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import assert_never

import numpy as np

from sim_nodes.geometry import Array, Quaternion, Vector, quaternion_of, rotation_matrix, vector
from sim_nodes.physics import IDENTITY, BodyModel, BodyState, Box, Cylinder, Part, Shape, Sphere

ROUND = 48  # corners of a round outline
DIGITS = 9  # of coordinates [m]; closer corners are merged
FLOOR_TOLERANCE = 1e-3  # [m] that a body may start below the floor


def outline(part: Part, state: BodyState) -> Array:
    """Return the convex outline of a part of a body in a state, counterclockwise, shape (n, 2) [m]."""
    body = rotation_matrix(state.orientation)
    corners = np.array(list(_corners(part))) @ rotation_matrix(part.orientation).T + part.position
    seen: Array = (corners @ body.T + state.position)[:, :2]
    if isinstance(part.shape, Sphere):
        angles = np.linspace(0.0, 2 * math.pi, ROUND, endpoint=False)
        circle: Array = seen[0] + part.shape.radius * np.column_stack([np.cos(angles), np.sin(angles)])
        return circle
    return _hull(np.round(seen, DIGITS))


def _corners(part: Part) -> Iterable[tuple[float, float, float]]:
    match part.shape:
        case Box(size=(x, y, z)):
            return [(i * x / 2, j * y / 2, k * z / 2) for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]
        case Cylinder(radius=radius, length=length):
            angles = np.linspace(0.0, 2 * math.pi, ROUND, endpoint=False).tolist()
            return [(radius * math.cos(a), radius * math.sin(a), k * length / 2) for a in angles for k in (-1, 1)]
        case Sphere():
            return [(0.0, 0.0, 0.0)]
        case _:
            assert_never(part.shape)


def _hull(points: Array) -> Array:
    """Return the convex hull of points in the plane by monotone chains [Andrew 1979]."""
    ordered = sorted(map(tuple, points.tolist()))
    lower, upper = _chain(ordered), _chain(ordered[::-1])
    return np.array(lower[:-1] + upper[:-1])


def _chain(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    chain: list[tuple[float, float]] = []
    for x, y in points:
        while len(chain) > 1:
            (ax, ay), (bx, by) = chain[-2:]
            if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0.0:
                break
            chain.pop()
        chain.append((x, y))
    return chain


def lowest_point(model: BodyModel, state: BodyState) -> float:
    """Return the height of the lowest point of a body in a state [m]."""
    return min(lowest_of(part, state) for part in model.parts)


def lowest_of(part: Part, state: BodyState) -> float:
    """Return the height of the lowest point of a part of a body in a state [m]."""
    body = rotation_matrix(state.orientation)
    centre = float((body @ part.position)[2]) + state.position[2]
    up = (body @ rotation_matrix(part.orientation))[2]  # the world's z axis in the part's frame
    return centre - reach(part.shape, up)


def reach(shape: Shape, direction: Array) -> float:
    """Return the extent of a shape from its centre along a unit vector in its frame, shape (3,) [m]."""
    match shape:
        case Box(size=size):
            return float(np.abs(direction) @ size) / 2
        case Cylinder(radius=radius, length=length):
            across = float(np.hypot(direction[0], direction[1]))
            return abs(float(direction[2])) * length / 2 + across * radius
        case Sphere(radius=radius):
            return radius
        case _:
            assert_never(shape)


@dataclass(frozen=True)
class BoundingBox:
    """An axis-aligned box in a frame, by two corners of shape (3,) [m]."""

    lower: Array
    upper: Array


def bounding_box(parts: Iterable[Part]) -> BoundingBox | None:
    """Return the smallest box around all parts, in their frame; None without parts."""
    boxes = [box_around(part) for part in parts]
    if not boxes:
        return None
    lower = np.min([box.lower for box in boxes], axis=0)
    return BoundingBox(lower, np.max([box.upper for box in boxes], axis=0))


def box_around(part: Part) -> BoundingBox:
    """Return the smallest box around a part, in the frame of its body."""
    # The rows of the rotation are the axes of the body in the frame of the part.
    half = np.array([reach(part.shape, axis) for axis in rotation_matrix(part.orientation)])
    return BoundingBox(np.array(part.position) - half, np.array(part.position) + half)


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
