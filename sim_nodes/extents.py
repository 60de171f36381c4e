"""Sizes of bodies: outlines on the floor as seen from above, lowest points, and bounding boxes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any, assert_never

import numpy as np

from seoro.deferred import dataclass
from sim_nodes.geometry import Array, rotation_matrix
from sim_nodes.physics import BodyModel, BodyState, Box, Capsule, Cylinder, Hull, Part, Shape, Sphere

ROUND = 48  # corners of a round outline
DIGITS = 9  # of coordinates [m]; closer corners are merged
FLOOR_TOLERANCE = 1e-3  # [m] that a body may start below the floor


def outline(part: Part, state: BodyState) -> Array:
    """Return the convex outline of a part of a body in a state, counterclockwise, shape (n, 2) [m]."""
    body = rotation_matrix(state.orientation)
    corners = np.array(list(_corners(part.shape))) @ rotation_matrix(part.orientation).T + part.position
    seen: Array = (corners @ body.T + state.position)[:, :2]
    if isinstance(part.shape, Sphere | Capsule):
        angles = np.linspace(0.0, 2 * math.pi, ROUND, endpoint=False)
        circle = part.shape.radius * np.column_stack([np.cos(angles), np.sin(angles)])
        seen = (seen[:, None] + circle).reshape(-1, 2)
    return _hull(np.round(seen, DIGITS))


def points_of(part: Part, state: BodyState) -> Array:
    """Return points at the surface of a part of a body in a state: corners, or lowest points, shape (n, 3) [m]."""
    body = rotation_matrix(state.orientation)
    corners = np.array(list(_corners(part.shape))) @ rotation_matrix(part.orientation).T + part.position
    found: Array = corners @ body.T + state.position
    if isinstance(part.shape, Sphere | Capsule):
        found[:, 2] -= part.shape.radius
    return found


def _corners(shape: Shape) -> Sequence[Any]:
    match shape:
        case Box(size=(x, y, z)):
            return [(i * x / 2, j * y / 2, k * z / 2) for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)]
        case Cylinder(radius=radius, length=length):
            angles = np.linspace(0.0, 2 * math.pi, ROUND, endpoint=False).tolist()
            return [(radius * math.cos(a), radius * math.sin(a), k * length / 2) for a in angles for k in (-1, 1)]
        case Capsule(length=length):
            return [(0.0, 0.0, -length / 2), (0.0, 0.0, length / 2)]
        case Sphere():
            return [(0.0, 0.0, 0.0)]
        case Hull():
            return list(shape.points)
        case _:
            assert_never(shape)


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
    """Return the height of the lowest point of a body in a state [m]; that of its origin without solid shapes."""
    return min((lowest_of(part, state) for part in model.parts), default=state.position[2])


def lowest_of(part: Part, state: BodyState) -> float:
    """Return the height of the lowest point of a part of a body in a state [m]."""
    centre, up = _height(part, state)
    return centre - reach(part.shape, -up)


def highest_of(part: Part, state: BodyState) -> float:
    """Return the height of the highest point of a part of a body in a state [m]."""
    centre, up = _height(part, state)
    return centre + reach(part.shape, up)


def _height(part: Part, state: BodyState) -> tuple[float, Array]:
    """Return the height of a part's origin [m], and the world's z axis in the part's frame, shape (3,)."""
    body = rotation_matrix(state.orientation)
    return float((body @ part.position)[2]) + state.position[2], (body @ rotation_matrix(part.orientation))[2]


def reach(shape: Shape, direction: Array) -> float:
    """Return the extent of a shape from its origin along a unit vector in its frame, shape (3,) [m]."""
    match shape:
        case Box(size=size):
            return float(np.abs(direction) @ size) / 2
        case Cylinder(radius=radius, length=length):
            across = float(np.hypot(direction[0], direction[1]))
            return abs(float(direction[2])) * length / 2 + across * radius
        case Capsule(radius=radius, length=length):
            return abs(float(direction[2])) * length / 2 + radius
        case Sphere(radius=radius):
            return radius
        case Hull():
            return float((shape.points @ direction).max())
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
    axes, position = rotation_matrix(part.orientation), np.array(part.position)
    lower, upper = (np.array([reach(part.shape, sign * axis) for axis in axes]) for sign in (-1.0, 1.0))
    return BoundingBox(position - lower, position + upper)
