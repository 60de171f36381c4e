"""Grids over the plane, and what is known of a world on one.

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
FAR = 10.0  # [m]; distances to walls are not told beyond it


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
        """The grid that covers an extent (lower x, lower y, upper x, upper y) [m]."""
        left, bottom, right, top = extent
        return cls(left, bottom, math.ceil((right - left) / RESOLUTION), math.ceil((top - bottom) / RESOLUTION))

    def framed(self) -> Grid:
        """The grid with one more row or column of cells on each side."""
        size = self.resolution
        return Grid(self.x - size, self.y - size, self.columns + 2, self.rows + 2, size)

    def contains(self, x: float, y: float) -> bool:
        """Whether a point is on the grid."""
        column, row = (x - self.x) / self.resolution, (y - self.y) / self.resolution
        return 0.0 <= column < self.columns and 0.0 <= row < self.rows

    def cell(self, x: float, y: float) -> tuple[int, int]:
        """The cell of a point, or the one nearest to it on the grid."""
        column = math.floor((x - self.x) / self.resolution)
        row = math.floor((y - self.y) / self.resolution)
        return min(max(column, 0), self.columns - 1), min(max(row, 0), self.rows - 1)

    def cells(self, x: Array, y: Array) -> tuple[Cells, Cells]:
        """The cells of points of any shape, those outside clipped to the border; coordinates have to be finite."""
        columns: Cells = ((x - self.x) * (1.0 / self.resolution)).astype(np.int64)
        rows: Cells = ((y - self.y) * (1.0 / self.resolution)).astype(np.int64)
        return columns.clip(0, self.columns - 1), rows.clip(0, self.rows - 1)

    def inside(self, x: Array, y: Array) -> NDArray[np.bool_]:
        """Which of some points are on the grid."""
        right, top = self.x + self.columns * self.resolution, self.y + self.rows * self.resolution
        on_grid: NDArray[np.bool_] = (x >= self.x) & (x < right) & (y >= self.y) & (y < top)
        return on_grid

    def centres(self) -> tuple[Array, Array]:
        """Coordinates of the cells' centres, each of shape (columns, rows)."""
        x = self.x + (np.arange(self.columns) + 0.5) * self.resolution
        y = self.y + (np.arange(self.rows) + 0.5) * self.resolution
        xs, ys = np.meshgrid(x, y, indexing="ij")
        return xs, ys

    def points(self, cells: Cells) -> Array:
        """Centres of cells given as (n, 2) indices, shape (n, 2) [m]."""
        corner = np.array([self.x, self.y])
        centres: Array = corner + (cells + 0.5) * self.resolution
        return centres

    def interpolate(self, field: Array, x: Array, y: Array) -> Array:
        """Values of a field at points, bilinear between the cells' centres and constant outside."""
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
    """What is known of a world beforehand: how far each cell's centre is from the next wall, 0 inside walls."""

    grid: Grid
    distance: Array  # [m], shape (columns, rows)
