"""Rendering by PyBullet's software renderer, which has no system requirements."""

from __future__ import annotations

import itertools
import math
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pybullet

from sim_nodes.physics import FLOOR
from sim_nodes.views import DAYLIGHT, FAR, FLOOR_TILES, NEAR, TILE, DepthImage, Light, Picture, View

AMBIENT, SUN, SPECULAR = 0.6, 0.35, 0.05  # Bullet's usual light
SUN_DISTANCE = 20.0  # [m]
BACKGROUND = 1.0  # of the depth buffer
NO_SHAPE = -1  # of a body that nothing touches
NO_BODY = -1  # where nothing is drawn
CORNERS = ((0, 0), (1, 0), (1, 1), (0, 1))
TRIANGLES = (0, 1, 2, 0, 2, 3)  # of a tile, by its corners

Extent = tuple[float, float, float, float]


def add_floor(bullet: Any, extent: Extent) -> int:
    """Add a floor, drawn as tiles in two colours; returns the number of its body."""
    plane = bullet.createCollisionShape(pybullet.GEOM_PLANE)
    with tempfile.TemporaryDirectory() as folder:  # Bullet reads the files for each body
        first, second = (
            bullet.createVisualShape(pybullet.GEOM_MESH, fileName=str(path), rgbaColor=colour)
            for path, colour in zip(_write_tiles(Path(folder), extent), FLOOR_TILES, strict=True)
        )
        floor: int = bullet.createMultiBody(0.0, plane, first)
        bullet.createMultiBody(0.0, NO_SHAPE, second)
    return floor


def _write_tiles(folder: Path, extent: Extent) -> Iterator[Path]:
    """Write the tiles of each colour as a file in OBJ; Bullet never frees meshes that it gets as lists."""
    for odd in (1, 0):
        vertices, indices = _tiles(extent, odd)
        lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices]
        lines.append("vn 0 0 1")
        corners = [f"{index + 1}//1" for index in indices]
        lines += [f"f {' '.join(corners[first : first + 3])}" for first in range(0, len(corners), 3)]
        path = folder / f"{odd}.obj"
        path.write_text("\n".join(lines))
        yield path


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


def draw(bullet: Any, view: View, light: Light) -> Picture:
    """Render a view."""
    colours, depths, _ = _image(bullet, view, light, shadow=True, flags=pybullet.ER_NO_SEGMENTATION_MASK)
    shape = (view.lens.height, view.lens.width)
    # PyBullet builds without numpy return tuples.
    picture = np.array(colours, dtype=np.uint8).reshape(*shape, 4)[:, :, :3].copy()
    empty = np.asarray(depths, dtype=np.float64).reshape(shape) >= BACKGROUND
    picture[empty] = np.round(255 * np.array(light.sky[:3]))
    return picture


def measure(bullet: Any, view: View, owners: Mapping[int, str]) -> DepthImage:
    """Measure the distances of a view; `owners` are the entities of bodies, except for parts of the floor."""
    _, depths, bodies = _image(bullet, view, DAYLIGHT, shadow=False, flags=0)
    shape = (view.lens.height, view.lens.width)
    buffer = np.asarray(depths, dtype=np.float64).reshape(shape)
    distances = (FAR * NEAR / (FAR - (FAR - NEAR) * buffer)).astype(np.float32)
    distances[buffer >= BACKGROUND] = np.inf
    numbers = np.asarray(bodies, dtype=np.int32).reshape(shape)
    return DepthImage.of(
        distances, numbers, lambda number: None if number == NO_BODY else owners.get(number, FLOOR)
    )


def _image(bullet: Any, view: View, light: Light, *, shadow: bool, flags: int) -> tuple[Any, Any, Any]:
    """Return colours, depth buffer and body numbers of a view."""
    ahead, up = view.axes
    *_, colours, depths, bodies = bullet.getCameraImage(
        view.lens.width,
        view.lens.height,
        bullet.computeViewMatrix(view.position, (np.array(view.position) + ahead).tolist(), up.tolist()),
        bullet.computeProjectionMatrixFOV(math.degrees(view.lens.fov), view.lens.aspect, NEAR, FAR),
        lightDirection=[-part for part in light.direction],  # towards the light
        lightDistance=SUN_DISTANCE,
        lightAmbientCoeff=AMBIENT * light.ambient * light.brightness,
        lightDiffuseCoeff=SUN * light.diffuse * light.brightness,
        lightSpecularCoeff=SPECULAR * light.diffuse * light.brightness,
        shadow=shadow,
        renderer=pybullet.ER_TINY_RENDERER,
        flags=flags,
    )
    return colours, depths, bodies
