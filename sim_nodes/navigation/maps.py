"""Grids over the plane, and maps on them: the distance of each cell to the nearest object.

Arrays are indexed [column along x, row along y]; the centre of cell (0, 0) is half a cell inside the lower corner.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from seoro.deferred import dataclass
from sim_nodes.geometry import Array
from sim_nodes.physics import Wall

Cells = NDArray[np.int64]
RESOLUTION = 0.05  # [m]
FAR = 10.0  # [m] maximum of stored distances to walls


@dataclass(frozen=True)
class Grid:
    """Cells of `resolution` [m], `columns` by `rows`, from the corner (x, y) [m]."""

    x: float
    y: float
    columns: int
    rows: int
    resolution: float = RESOLUTION

    @classmethod
    def over(cls, extent: tuple[float, float, float, float]) -> Grid:
        """Return the grid that covers an extent (lower x, lower y, upper x, upper y) [m]."""
        left, bottom, right, top = extent
        return cls(left, bottom, math.ceil((right - left) / RESOLUTION), math.ceil((top - bottom) / RESOLUTION))

    def framed(self) -> Grid:
        """Return the grid with a border of one cell."""
        size = self.resolution
        return Grid(self.x - size, self.y - size, self.columns + 2, self.rows + 2, size)

    def contains(self, x: float, y: float) -> bool:
        """Whether a point is on the grid."""
        column, row = (x - self.x) / self.resolution, (y - self.y) / self.resolution
        return 0.0 <= column < self.columns and 0.0 <= row < self.rows

    def cell(self, x: float, y: float) -> tuple[int, int]:
        """Return the cell of a point, or the nearest one on the grid."""
        column = math.floor((x - self.x) / self.resolution)
        row = math.floor((y - self.y) / self.resolution)
        return min(max(column, 0), self.columns - 1), min(max(row, 0), self.rows - 1)

    def cells(self, x: Array, y: Array) -> tuple[Cells, Cells]:
        """Return the cells of finite points of any shape; points outside are clipped to the border."""
        columns: Cells = ((x - self.x) * (1.0 / self.resolution)).astype(np.int64)
        rows: Cells = ((y - self.y) * (1.0 / self.resolution)).astype(np.int64)
        # Faster than `clip`, which counts for small arrays.
        columns, rows = np.maximum(columns, 0), np.maximum(rows, 0)
        return np.minimum(columns, self.columns - 1), np.minimum(rows, self.rows - 1)

    def inside(self, x: Array, y: Array) -> NDArray[np.bool_]:
        """Return which points are on the grid."""
        right, top = self.x + self.columns * self.resolution, self.y + self.rows * self.resolution
        on_grid: NDArray[np.bool_] = (x >= self.x) & (x < right) & (y >= self.y) & (y < top)
        return on_grid

    def centres(self) -> tuple[Array, Array]:
        """Return the coordinates of the cells' centres, each of shape (columns, rows)."""
        x = self.x + (np.arange(self.columns) + 0.5) * self.resolution
        y = self.y + (np.arange(self.rows) + 0.5) * self.resolution
        xs, ys = np.meshgrid(x, y, indexing="ij")
        return xs, ys

    def points(self, cells: Cells) -> Array:
        """Return the centres of cells given as (n, 2) indices, shape (n, 2) [m]."""
        corner = np.array([self.x, self.y])
        centres: Array = corner + (cells + 0.5) * self.resolution
        return centres

    def interpolate(self, field: Array, x: Array, y: Array) -> Array:
        """Return bilinearly interpolated values of a field at points, constant outside."""
        u = np.minimum(np.maximum((x - self.x) / self.resolution - 0.5, 0.0), self.columns - 1.001)
        v = np.minimum(np.maximum((y - self.y) / self.resolution - 0.5, 0.0), self.rows - 1.001)
        i, j = u.astype(np.int64), v.astype(np.int64)
        a, b = u - i, v - j
        values, corner = field.ravel(), i * self.rows + j
        low = values.take(corner) * (1.0 - a) + values.take(corner + self.rows) * a
        high = values.take(corner + 1) * (1.0 - a) + values.take(corner + self.rows + 1) * a
        value: Array = low * (1.0 - b) + high * b
        return value


@dataclass(frozen=True)
class NavigationMap:
    """A map of a world: distance of each cell's centre to the nearest wall, 0 inside walls."""

    grid: Grid
    distance: Array  # [m], shape (columns, rows)


Outline = Array  # of a convex object, counterclockwise, shape (n, 2) [m]


def build_map(
    extent: tuple[float, float, float, float], walls: Iterable[Wall], outlines: Iterable[Outline] = ()
) -> NavigationMap:
    """Build the map of a world. Distances are exact, not counted in cells.

    Args:
        extent: Lower x, lower y, upper x, upper y of the map [m].
        walls: Walls of the world.
        outlines: Outlines of other objects.
    """
    grid = Grid.over(extent)
    solids: list[Wall | Outline] = [*walls, *outlines]
    xs, ys = grid.centres()
    distance = np.full(xs.shape, FAR)
    reach = _reach(grid, solids, xs, ys)
    for solid in solids:
        near = _window(grid, solid, reach)
        np.minimum(distance[near], _distance_to(solid, xs[near], ys[near]), out=distance[near])
    return NavigationMap(grid, distance)


def _reach(grid: Grid, solids: Sequence[Wall | Outline], xs: Array, ys: Array) -> float:
    """Return a distance that no cell exceeds to its nearest object [m], which bounds the search."""
    covered: NDArray[np.bool_] = np.zeros(xs.shape, dtype=np.bool_)
    for solid in solids:
        near = _window(grid, solid, grid.resolution)
        covered[near] |= _distance_to(solid, xs[near], ys[near]) == 0.0
    if not covered.any():
        return FAR
    return min(FAR, (_most_steps(covered) + 1) * grid.resolution)


def _most_steps(covered: NDArray[np.bool_]) -> int:
    """Return the largest number of steps along the axes from a cell to the nearest covered one, an upper bound."""
    steps = np.where(covered, 0, sum(covered.shape))
    for axis in (0, 1):
        for way in (1, -1):
            turned = np.moveaxis(steps, axis, 0)[::way]  # a view
            count = np.arange(len(turned))[:, None]
            turned[...] = np.minimum.accumulate(turned - count, axis=0) + count
    return int(steps.max())


def _window(grid: Grid, solid: Wall | Outline, reach: float) -> tuple[slice, slice]:
    """Return the cells within a distance of an object's bounding box."""
    left, bottom, right, top = _bounds(solid)
    first = grid.cell(left - reach, bottom - reach)
    last = grid.cell(right + reach, top + reach)
    return slice(first[0], last[0] + 1), slice(first[1], last[1] + 1)


def _bounds(solid: Wall | Outline) -> tuple[float, float, float, float]:
    if isinstance(solid, Wall):
        cos, sin = abs(math.cos(solid.yaw)), abs(math.sin(solid.yaw))
        x = (cos * solid.length + sin * solid.thickness) / 2
        y = (sin * solid.length + cos * solid.thickness) / 2
        return solid.x - x, solid.y - y, solid.x + x, solid.y + y
    (left, bottom), (right, top) = solid.min(axis=0).tolist(), solid.max(axis=0).tolist()
    return left, bottom, right, top


def _distance_to(solid: Wall | Outline, xs: Array, ys: Array) -> Array:
    return _distance_to_wall(solid, xs, ys) if isinstance(solid, Wall) else _distance_to_outline(solid, xs, ys)


def _distance_to_wall(wall: Wall, xs: Array, ys: Array) -> Array:
    cos, sin = math.cos(wall.yaw), math.sin(wall.yaw)
    dx, dy = xs - wall.x, ys - wall.y
    along = np.abs(cos * dx + sin * dy) - wall.length / 2
    across = np.abs(cos * dy - sin * dx) - wall.thickness / 2
    distance: Array = np.hypot(along.clip(0.0), across.clip(0.0))
    return distance


def _distance_to_outline(outline: Outline, xs: Array, ys: Array) -> Array:
    """Return the distance to the nearest edge, 0 inside, which is left of all edges."""
    squares = np.full(xs.shape, np.inf)
    inside = np.ones(xs.shape, dtype=np.bool_)
    corners = outline.tolist()
    for (ax, ay), (bx, by) in pairwise([*corners, corners[0]]):
        dx, dy, px, py = bx - ax, by - ay, xs - ax, ys - ay
        along = ((px * dx + py * dy) / (dx * dx + dy * dy)).clip(0.0, 1.0)
        np.minimum(squares, (px - along * dx) ** 2 + (py - along * dy) ** 2, out=squares)
        inside &= dx * py >= dy * px
    distance: Array = np.where(inside, 0.0, np.sqrt(squares))
    return distance
