"""Distances of convex polygons to bodies and other convex polygons, from above.

From above, each shape is the hull of some points, widened by a radius: a sphere is a point, a capsule is a line.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product
from typing import assert_never

import numpy as np

from seoro.deferred import dataclass
from sim_nodes.geometry import Array, Pose2, rotation_matrix
from sim_nodes.physics import BodyModel, BodyState, Box, Capsule, Cylinder, Hull, Part, Sphere
from sim_nodes.robots.footprint import Footprint

UPRIGHT = 1e-6  # sine of the tilt up to which a cylinder is a circle from above
RIM = 48  # points on each rim of a tilted cylinder; their hull is at most 0.3 % of the radius within it
CUBE = np.array(tuple(product((-0.5, 0.5), repeat=3)))


@dataclass(frozen=True)
class Shadow:
    """A shape from above: a convex polygon, line or point, widened by a radius.

    Attributes:
        corners: Corners, counterclockwise, shape (n, 2) [m].
        radius: Radius [m].
    """

    corners: Array
    radius: float = 0.0


def placed_corners(footprint: Footprint, pose: Pose2) -> Array:
    """Return the corners of a footprint at a pose, shape (n, 2) [m]."""
    cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
    corners: Array = footprint.points @ np.array(((cos, sin), (-sin, cos))) + (pose.x, pose.y)
    return corners


def distance_to_shadow(polygon: Array, other: Shadow) -> float:
    """Return the distance between a convex polygon and a shadow [m]; 0 if they overlap.

    Args:
        polygon: At least three corners, counterclockwise, shape (n, 2) [m].
        other: The shadow.
    """
    if not _is_apart(polygon, other.corners):
        return 0.0
    nearest = min(_least_to_edges(polygon, other.corners), _least_to_edges(other.corners, polygon))
    return max(0.0, nearest - other.radius)


def distance_from_polygon(polygon: Array, model: BodyModel, state: BodyState) -> float:
    """Return the distance of a convex polygon to a body [m]; 0 if they overlap. Parts at all heights count."""
    return min((distance_to_shadow(polygon, shadow) for shadow in _shadows(model, state)), default=math.inf)


def _is_apart(polygon: Array, others: Array) -> bool:
    """Whether an edge of either polygon separates them; the second may also be a line or point."""
    for first, second in ((polygon, others), (others, polygon)):
        edges = np.roll(first, -1, axis=0) - first
        normals = np.column_stack([edges[:, 1], -edges[:, 0]])  # outwards
        away = np.einsum("ij,ikj->ik", normals, second[None] - first[:, None])
        if bool((away > 0.0).all(axis=1).any()):
            return True
    return False


def _least_to_edges(points: Array, corners: Array) -> float:
    """Return the least distance of points to the edges between corners [m]."""
    edges = np.roll(corners, -1, axis=0) - corners
    away = points[:, None] - corners
    squares = np.einsum("ij,ij->i", edges, edges)
    shares = np.einsum("ijk,jk->ij", away, edges) / np.where(squares > 0.0, squares, 1.0)
    beside = away - shares.clip(0.0, 1.0)[..., None] * edges
    return float(np.hypot(beside[..., 0], beside[..., 1]).min())


def _shadows(model: BodyModel, state: BodyState) -> Iterator[Shadow]:
    turn, place = rotation_matrix(state.orientation), np.array(state.position)
    for part in model.parts:
        centre = place + turn @ part.position
        yield _shadow(part, centre, turn @ rotation_matrix(part.orientation))


def _shadow(part: Part, centre: Array, turn: Array) -> Shadow:
    """Return the shadow of a part, given the position and axes of its shape in `map`."""
    axis = turn[:2, 2]
    match part.shape:
        case Box(size=size):
            return Shadow(_hull(centre[:2] + (CUBE * size) @ turn[:2].T))
        case Cylinder(radius=radius, length=length):
            if math.hypot(*axis) < UPRIGHT:
                return Shadow(centre[None, :2], radius)
            angles = np.linspace(0.0, 2.0 * np.pi, RIM, endpoint=False)
            rim = radius * np.column_stack([np.cos(angles), np.sin(angles)]) @ turn[:2, :2].T
            return Shadow(_hull(centre[:2] + np.vstack([rim + axis * length / 2, rim - axis * length / 2])))
        case Sphere(radius=radius):
            return Shadow(centre[None, :2], radius)
        case Capsule(radius=radius, length=length):
            return Shadow(centre[:2] + np.outer((length / 2, -length / 2), axis), radius)
        case Hull(points=points):
            return Shadow(_hull(centre[:2] + points @ turn[:2].T))
        case _:
            assert_never(part.shape)


def _hull(points: Array) -> Array:
    from scipy.spatial import ConvexHull  # noqa: PLC0415 - slow to load, and round robots need none

    corners: Array = points[ConvexHull(points).vertices]
    return corners
