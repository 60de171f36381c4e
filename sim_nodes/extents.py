"""How far bodies reach: what they cover of the floor, seen from above, and how low they come."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import assert_never

import numpy as np

from sim_nodes.geometry import Array, rotation_matrix
from sim_nodes.physics import BodyModel, BodyState, Box, Cylinder, Part, Shape, Sphere

ROUND = 48  # corners of what is round
DIGITS = 9  # of coordinates [m]: corners that differ by less are one
FLOOR_TOLERANCE = 1e-3  # [m] that a body may begin below the floor


def outline(part: Part, state: BodyState) -> Array:
    """The convex outline of a part of a body in a state, counterclockwise, shape (n, 2) [m]."""
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
    """The convex hull of points in the plane, by their monotone chain [Andrew 1979]."""
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
    """Height of the lowest point of a body in a state [m]."""
    return min(lowest_of(part, state) for part in model.parts)


def lowest_of(part: Part, state: BodyState) -> float:
    """Height of the lowest point of a part of a body in a state [m]."""
    body = rotation_matrix(state.orientation)
    centre = float((body @ part.position)[2]) + state.position[2]
    up = (body @ rotation_matrix(part.orientation))[2]  # the world's z axis in the part's frame
    return centre - reach(part.shape, up)


def reach(shape: Shape, direction: Array) -> float:
    """How far a shape reaches from its centre along a direction in its frame, a unit vector of shape (3,) [m]."""
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
