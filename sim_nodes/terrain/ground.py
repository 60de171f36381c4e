"""The ground of a world: the floor at z = 0, and terrain on it, which only raises it.

Contacts with terrain are contacts with the floor, and never collisions.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np

from seoro.deferred import dataclass
from sim_nodes.geometry import Array, Pose2

FLOOR_FRICTION = 1.0
CORNERS = ((-1, -1), (1, -1), (1, 1), (-1, 1))


@dataclass(frozen=True)
class Slab:
    """A solid on the floor with a plane top, which rises or falls along its length.

    Attributes:
        place: Its centre and direction.
        length: [m].
        width: [m].
        low: Height at the begin [m].
        high: Height at the end [m].
        friction: Coefficient of sliding friction; None for that of the floor.
    """

    place: Pose2
    length: float
    width: float
    low: float
    high: float
    friction: float | None = None

    @property
    def is_level(self) -> bool:
        """Whether it is a box."""
        return self.low == self.high

    @property
    def top(self) -> float:
        """Its greatest height [m]."""
        return max(self.low, self.high)

    @property
    def corners(self) -> tuple[tuple[float, float], ...]:
        """Corners of its outline, counterclockwise [m]."""
        return _corners(self.place, self.length, self.width)

    @property
    def points(self) -> Array:
        """Corners of the solid relative to its place, in its own axes, shape (8, 3) [m].

        The last bit of a number is 1 at the top, the one before on the left, the first at the end of the length.
        """
        ends, sides = ((-1, self.low), (1, self.high)), (-1, 1)
        return np.array(
            [
                (end * self.length / 2, side * self.width / 2, z)
                for end, height in ends
                for side in sides
                for z in (0.0, height)
            ]
        )

    def heights(self, x: Array, y: Array) -> Array:
        """Return its height at points of the map, 0 outside, in the shape of `x` and `y` [m]."""
        along, left = _own(self.place, x, y)
        inside = (np.abs(along) <= self.length / 2) & (np.abs(left) <= self.width / 2)
        raised: Array = np.where(inside, self.low + (self.high - self.low) * (along / self.length + 0.5), 0.0)
        return raised


@dataclass(frozen=True)
class HeightField:
    """Heights on a regular grid that ends at its edges; each cell is two triangles.

    The second corner along the length and the second one to the left of a cell are on the edge between the two.

    Attributes:
        place: Its centre and direction.
        length: [m].
        width: [m].
        columns: Number of points along the length, at least 2.
        rows: Number of points along the width, at least 2.
        data: Heights, 0 at all edges [m], little-endian doubles, row by row along the length, the rows from right
            to left.
        friction: Coefficient of sliding friction; None for that of the floor.
    """

    place: Pose2
    length: float
    width: float
    columns: int
    rows: int
    data: bytes
    friction: float | None = None

    @cached_property
    def grid(self) -> Array:
        """The heights, shape (rows, columns) [m]."""
        return np.frombuffer(self.data, "<f8").reshape(self.rows, self.columns)

    @property
    def top(self) -> float:
        """Its greatest height [m]."""
        return float(self.grid.max())

    @property
    def corners(self) -> tuple[tuple[float, float], ...]:
        """Corners of its outline, counterclockwise [m]."""
        return _corners(self.place, self.length, self.width)

    @property
    def spacing(self) -> tuple[float, float]:
        """Distance of points along the length and the width [m]."""
        return self.length / (self.columns - 1), self.width / (self.rows - 1)

    def heights(self, x: Array, y: Array) -> Array:
        """Return its height at points of the map, 0 outside, in the shape of `x` and `y` [m]."""
        along, left = _own(self.place, x, y)
        dx, dy = self.spacing
        u, v = along / dx + (self.columns - 1) / 2, left / dy + (self.rows - 1) / 2
        inside = (u >= 0.0) & (u <= self.columns - 1) & (v >= 0.0) & (v <= self.rows - 1)
        column = np.clip(u.astype(np.int64), 0, self.columns - 2)
        row = np.clip(v.astype(np.int64), 0, self.rows - 2)
        a, b, grid = u - column, v - row, self.grid
        first, second = grid[row, column], grid[row + 1, column + 1]
        ahead, beside = grid[row, column + 1], grid[row + 1, column]
        lower = first + a * (ahead - first) + b * (beside - first)
        upper = second + (1.0 - a) * (beside - second) + (1.0 - b) * (ahead - second)
        raised: Array = np.where(inside, np.where(a + b <= 1.0, lower, upper), 0.0)
        return raised


def _own(place: Pose2, x: Array, y: Array) -> tuple[Array, Array]:
    """Return points of the map along the length of a place and to its left [m]."""
    cos, sin = math.cos(place.yaw), math.sin(place.yaw)
    return cos * (x - place.x) + sin * (y - place.y), cos * (y - place.y) - sin * (x - place.x)


def _corners(place: Pose2, length: float, width: float) -> tuple[tuple[float, float], ...]:
    found = (place.compose(Pose2(i * length / 2, j * width / 2, 0.0)) for i, j in CORNERS)
    return tuple((corner.x, corner.y) for corner in found)


@dataclass(frozen=True)
class Ground:
    """Friction of the floor, and the terrain on it."""

    friction: float = FLOOR_FRICTION
    slabs: tuple[Slab, ...] = ()
    fields: tuple[HeightField, ...] = ()

    @property
    def is_flat(self) -> bool:
        """Whether it is the floor alone."""
        return not (self.slabs or self.fields)

    @property
    def pieces(self) -> tuple[Slab | HeightField, ...]:
        """The terrain."""
        return (*self.slabs, *self.fields)

    @property
    def top(self) -> float:
        """Its greatest height [m]."""
        return max((piece.top for piece in self.pieces), default=0.0)

    def friction_of(self, piece: Slab | HeightField) -> float:
        """Return the coefficient of sliding friction of a piece of terrain."""
        return self.friction if piece.friction is None else piece.friction

    def heights(self, x: Array, y: Array) -> Array:
        """Return the height of the ground at points of the map, in the shape of `x` and `y` [m]."""
        found: Array = np.zeros(np.shape(x))
        for piece in self.pieces:
            np.maximum(found, piece.heights(x, y), out=found)
        return found

    def height(self, x: float, y: float) -> float:
        """Return the height of the ground at a point of the map [m]."""
        return 0.0 if self.is_flat else float(self.heights(np.array([x]), np.array([y]))[0])


FLAT = Ground()
