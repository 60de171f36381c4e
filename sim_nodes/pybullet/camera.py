"""Rendering by PyBullet's software renderer, which has no system requirements."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pybullet

from sim_nodes.views import FAR, FLOOR_TILES, LIGHT_DIRECTION, NEAR, SKY, TILE, Picture, View

SUN = tuple(-part for part in LIGHT_DIRECTION)  # direction towards the light
SUN_DISTANCE = 20.0  # [m]
BACKGROUND = 1.0  # of the depth buffer
UP = (0.0, 0.0, 1.0)
CORNERS = ((0, 0), (1, 0), (1, 1), (0, 1))
TRIANGLES = (0, 1, 2, 0, 2, 3)  # of a tile, by its corners

Extent = tuple[float, float, float, float]


def floor_shapes(bullet: Any, extent: Extent) -> tuple[int, int]:
    """Add a floor of tiles in two colours; returns the numbers of both shapes. Bullet's own is infinite."""
    first, second = (
        bullet.createVisualShape(
            pybullet.GEOM_MESH, vertices=vertices, normals=[UP] * len(vertices), indices=indices, rgbaColor=colour
        )
        for colour, (vertices, indices) in zip(FLOOR_TILES, (_tiles(extent, odd) for odd in (1, 0)), strict=True)
    )
    return first, second


def _tiles(extent: Extent, odd: int) -> tuple[list[tuple[float, float, float]], list[int]]:
    """Return vertices and indices of every other tile; tiles are cut at the edges."""
    left, bottom, right, top = extent
    columns = range(math.floor(left / TILE), math.ceil(right / TILE))
    rows = range(math.floor(bottom / TILE), math.ceil(top / TILE))
    vertices: list[tuple[float, float, float]] = []
    indices: list[int] = []
    for column, row in itertools.product(columns, rows):
        if (column + row) % 2 == odd:
            indices += [len(vertices) + corner for corner in TRIANGLES]
            vertices += [
                (min(max((column + i) * TILE, left), right), min(max((row + j) * TILE, bottom), top), 0.0)
                for i, j in CORNERS
            ]
    return vertices, indices


def draw(bullet: Any, view: View) -> Picture:
    """Render a view."""
    width, height = view.lens.width, view.lens.height
    ahead, up = view.axes
    *_, colours, depths, _ = bullet.getCameraImage(
        width,
        height,
        bullet.computeViewMatrix(view.position, (np.array(view.position) + ahead).tolist(), up.tolist()),
        bullet.computeProjectionMatrixFOV(math.degrees(view.lens.fov), view.lens.aspect, NEAR, FAR),
        lightDirection=SUN,
        lightDistance=SUN_DISTANCE,
        shadow=True,
        renderer=pybullet.ER_TINY_RENDERER,
        flags=pybullet.ER_NO_SEGMENTATION_MASK,
    )
    # PyBullet builds without numpy return tuples.
    picture = np.array(colours, dtype=np.uint8).reshape(height, width, 4)[:, :, :3].copy()
    empty = np.asarray(depths, dtype=np.float64).reshape(height, width) >= BACKGROUND
    picture[empty] = np.round(255 * np.array(SKY[:3]))
    return picture
