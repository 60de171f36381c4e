"""Grids over the plane, and maps on them.

Arrays are indexed [column along x, row along y]; the centre of cell (0, 0) is half a cell inside the lower corner.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim_nodes.geometry import Array

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
        return columns.clip(0, self.columns - 1), rows.clip(0, self.rows - 1)

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
        u = ((x - self.x) / self.resolution - 0.5).clip(0.0, self.columns - 1.001)
        v = ((y - self.y) / self.resolution - 0.5).clip(0.0, self.rows - 1.001)
        i, j = u.astype(np.int64), v.astype(np.int64)
        a, b = u - i, v - j
        low = field[i, j] * (1.0 - a) + field[i + 1, j] * a
        high = field[i, j + 1] * (1.0 - a) + field[i + 1, j + 1] * a
        value: Array = low * (1.0 - b) + high * b
        return value


@dataclass(frozen=True)
class NavigationMap:
    """A map of a world: distance of each cell's centre to the nearest wall, 0 inside walls."""

    grid: Grid
    distance: Array  # [m], shape (columns, rows)
