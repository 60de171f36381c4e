"""Surfaces of boxes, cylinders and spheres with texture coordinates, to show pictures on them.

A box has the whole picture on each side, upright, and on top with its upper edge to the left. Around cylinders and
spheres, the middle of the picture is ahead, along x. The ends of a cylinder have a disc of it.
"""

from __future__ import annotations

import math

import numpy as np

from sim_nodes.geometry import Array
from sim_nodes.models.meshes import Mesh
from sim_nodes.physics import Box, Cylinder, Shape, Sphere

AROUND = 48  # parts of a turn
RINGS = 24  # of a sphere
SMALLEST = 1e-15  # [m^2] twice the area of a triangle
X, Y, Z = np.eye(3)
SIDES = np.array([(-Y, X, Z), (X, Y, Z), (Y, -X, Z), (-X, -Y, Z), (Z, X, Y), (-Z, X, -Y)])
"""Normal, right and up of the sides of a box, seen from outside, shape (6, 3, 3)."""


def surface_of(shape: Shape) -> Mesh | None:
    """Return the surface of a shape; None for shapes without pictures."""
    match shape:
        case Box(size=size):
            return _box(np.array(size) / 2.0)
        case Cylinder(radius=radius, length=length):
            return _turned(
                np.array([0.0, radius, radius, radius, radius, 0.0]),
                length * np.array([-0.5, -0.5, -0.5, 0.5, 0.5, 0.5]),
                np.array([math.nan, math.nan, 0.0, 1.0, math.nan, math.nan]),
            )
        case Sphere(radius=radius):
            heights = np.linspace(0.0, 1.0, RINGS + 1)
            bearings = math.pi * (heights - 0.5)
            return _turned(radius * np.cos(bearings), radius * np.sin(bearings), heights)
        case _:
            return None


def _box(half: Array) -> Mesh:
    corners = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    signs = 2.0 * corners - 1.0
    normal, right, up = (SIDES[:, None, axis] for axis in range(3))
    vertices = half * (normal + signs[:, :1] * right + signs[:, 1:] * up)
    quads = 4 * np.arange(6)[:, None, None] + np.array([(0, 1, 2), (0, 2, 3)])
    return Mesh(vertices.reshape(-1, 3), quads.reshape(-1, 3), coordinates=np.tile(corners, (6, 1)))


def _turned(radii: Array, heights: Array, shares: Array) -> Mesh:
    """Return a surface of revolution about z, from below.

    Args:
        radii: Radii of its rings [m], shape (n,).
        heights: Their heights [m].
        shares: Heights of the rings in the picture, from 0 to 1; those of discs are not a number.
    """
    turns = np.linspace(0.0, 1.0, AROUND + 1)
    cos, sin = np.cos(2.0 * math.pi * (turns - 0.5)), np.sin(2.0 * math.pi * (turns - 0.5))
    across = radii[:, None]
    vertices = np.stack(np.broadcast_arrays(across * cos, across * sin, heights[:, None]), axis=-1)
    disc = across / (2.0 * max(float(radii.max()), 1e-9))
    is_disc = np.isnan(shares)[:, None]
    right = np.where(is_disc, 0.5 + disc * cos, turns)
    up = np.where(is_disc, 0.5 + disc * sin, np.nan_to_num(shares)[:, None])
    ring, step = np.meshgrid(np.arange(len(radii) - 1), np.arange(AROUND), indexing="ij")
    first = (ring * (AROUND + 1) + step).ravel()
    above = first + AROUND + 1
    pairs = ((first, first + 1, above + 1), (first, above + 1, above))
    faces = np.concatenate([np.stack(each, axis=1) for each in pairs])
    points = vertices.reshape(-1, 3)
    a, b, c = points[faces.T]
    has_area = np.linalg.norm(np.cross(b - a, c - a), axis=1) > SMALLEST
    return Mesh(points, faces[has_area], coordinates=np.stack([right, up], axis=-1).reshape(-1, 2))
