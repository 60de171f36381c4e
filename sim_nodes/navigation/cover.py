"""Discs that cover the outline of a robot and its margin, to find out where it fits.

A pose is free if each disc is as far from obstacles as its radius. So a lookup in the field of distances replaces
a comparison of polygons (as in J. Ziegler, C. Stiller 2010: "Fast collision checking for intelligent vehicle
motion planning"). No disc protrudes from the polygon by more than the margin.
"""

from __future__ import annotations

from functools import cached_property, lru_cache

import numpy as np

from seoro.deferred import dataclass
from sim_nodes.geometry import Array
from sim_nodes.navigation.maps import Grid
from sim_nodes.robots.declaration import MobileDeclaration
from sim_nodes.robots.footprint import Footprint

LEAST_MARGIN = 0.01  # [m]
ROUND = 0.03  # [m] of the corners of a polygon beyond its inscribed circle, up to which a robot counts as round
CANDIDATES = 41  # places of discs along each side of the bounding box
HALF_CELL = 0.036  # [m] from the centre of a cell to its corners
FREE = 0.1  # [m]; larger gaps are not computed exactly


@dataclass(frozen=True)
class Cover:
    """Discs in the frame of the base.

    Attributes:
        discs: Rows of x, y and radius [m], shape (n, 3). The first disc is the largest one, the core.
    """

    discs: Array

    @property
    def is_round(self) -> bool:
        """Whether it is one disc around the origin."""
        return len(self.discs) == 1

    @cached_property
    def reach(self) -> float:
        """Radius of a circle around the origin that contains all discs [m]."""
        return float((np.hypot(self.discs[:, 0], self.discs[:, 1]) + self.discs[:, 2]).max())

    @cached_property
    def room(self) -> float:
        """Distance to obstacles that a cell of the core needs at least [m]."""
        radius = float(self.discs[0, 2])
        return radius if self.is_round else radius - HALF_CELL

    def cores(self, poses: Array) -> Array:
        """Return the centres of the core at poses (x, y, yaw) of shape (n, 3), shape (n, 2) [m]."""
        x, y, _ = self.discs[0]
        cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
        return np.column_stack([poses[:, 0] + cos * x - sin * y, poses[:, 1] + sin * x + cos * y])

    def gaps(self, grid: Grid, distance: Array, poses: Array) -> Array:
        """Return the least gap between discs and obstacles at poses [m], negative where they overlap.

        A result above `FREE` is a lower bound.

        Args:
            grid: Grid of the map.
            distance: Distance of each cell to the nearest wall or obstacle [m].
            poses: Poses (x, y, yaw) in `map`, shape (n, 3).
        """
        gaps = grid.interpolate(distance, poses[:, 0], poses[:, 1]) - self.reach
        near = np.flatnonzero(gaps < FREE)
        if len(near):
            gaps[near] = self.disc_gaps(grid, distance, poses[near]).min(axis=1)
        return gaps

    def disc_gaps(self, grid: Grid, distance: Array, poses: Array) -> Array:
        """Return the gap of each disc, shape (poses, discs); see `gaps`."""
        cos, sin = np.cos(poses[:, 2:]), np.sin(poses[:, 2:])
        x, y, radii = self.discs.T
        gaps: Array = (
            grid.interpolate(distance, poses[:, :1] + cos * x - sin * y, poses[:, 1:2] + sin * x + cos * y) - radii
        )
        return gaps

    def gaps_to(self, x: Array, y: Array, poses: Array) -> Array:
        """Return the gap between the discs at each pose and each point [m], shape (poses, points)."""
        cos, sin = np.cos(poses[:, 2:]), np.sin(poses[:, 2:])
        dx, dy = x - poses[:, :1], y - poses[:, 1:2]
        ahead, left = cos * dx + sin * dy, cos * dy - sin * dx
        gaps = np.full(ahead.shape, np.inf)
        for disc_x, disc_y, radius in self.discs.tolist():
            np.minimum(gaps, np.hypot(ahead - disc_x, left - disc_y) - radius, out=gaps)
        return gaps


def cover_of(declaration: MobileDeclaration) -> Cover:
    """Return the cover of a robot: its outline and the margin, `clearance` beyond `radius`."""
    footprint = declaration.footprint
    if footprint is None or footprint.radius - footprint.inner_radius < ROUND:
        return Cover(np.array([(0.0, 0.0, declaration.clearance)]))
    return polygon_cover(footprint, max(declaration.clearance - declaration.radius, LEAST_MARGIN))


@lru_cache(maxsize=64)
def polygon_cover(footprint: Footprint, margin: float) -> Cover:
    """Return discs that contain a polygon and are within `margin` [m] of it, by a greedy choice."""
    corners = footprint.points
    edges = np.roll(corners, -1, axis=0) - corners
    normals = np.column_stack([-edges[:, 1], edges[:, 0]]) / np.hypot(edges[:, 0], edges[:, 1])[:, None]
    x, y = np.linspace(corners.min(axis=0), corners.max(axis=0), CANDIDATES).T
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    inside = _depths(grid, corners, normals)
    centres, depths = grid[inside > 0.0], inside[inside > 0.0]
    step = min(margin / 2.0, float(np.ptp(corners, axis=0).min()) / 10.0)
    shares = np.linspace(0.0, 1.0, 2 + int(np.hypot(edges[:, 0], edges[:, 1]).max() / step))
    outline = (corners[:, None] + shares[:, None] * edges[:, None]).reshape(-1, 2)
    targets = np.vstack([outline, centres[::3]])
    radii = depths + margin
    away = np.hypot(centres[:, None, 0] - targets[:, 0], centres[:, None, 1] - targets[:, 1])
    covers = away <= radii[:, None] - step / 2.0
    # The core is the deepest place; of equal ones, that nearest to the origin.
    chosen = int(np.lexsort((np.hypot(centres[:, 0], centres[:, 1]), -depths.round(3)))[0])
    discs: list[int] = []
    while True:
        discs.append(chosen)
        covers = covers[:, ~covers[chosen]]
        counts = covers.sum(axis=1)
        chosen = int(counts.argmax())
        if counts[chosen] == 0:
            return Cover(np.column_stack([centres[discs], radii[discs]]))


def _depths(points: Array, corners: Array, normals: Array) -> Array:
    """Return the distance of points to the nearest edge of a polygon, negative outside [m]."""
    away = points[:, None, :] - corners
    depths: Array = np.einsum("ijk,jk->ij", away, normals).min(axis=1)
    return depths
