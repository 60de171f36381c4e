"""Footprints: the outline of a robot on the floor."""

from __future__ import annotations

from functools import cached_property
from typing import Annotated

import numpy as np
from pydantic import ConfigDict, Field, TypeAdapter

from seoro.deferred import dataclass
from sim_nodes.geometry import Array

Corner = tuple[float, float]
MIN_CORNERS, MAX_CORNERS = 3, 16
Corners = Annotated[tuple[Corner, ...], Field(min_length=MIN_CORNERS, max_length=MAX_CORNERS)]
CORNERS: TypeAdapter[tuple[Corner, ...]] = TypeAdapter(Corners, config=ConfigDict(allow_inf_nan=False))
FLAT = 5e-4  # [m] of a corner from the line between its neighbours, at which it is left out
FLATTEST = 1e-4  # [m^2] smallest area


@dataclass(frozen=True)
class Footprint:
    """A convex polygon in the frame of the base; corners are counterclockwise [m]."""

    corners: tuple[Corner, ...]

    @cached_property
    def points(self) -> Array:
        """The corners, shape (n, 2) [m]."""
        return np.array(self.corners)

    @cached_property
    def radius(self) -> float:
        """Radius of the smallest circle around the base's origin that contains the polygon [m]."""
        return float(np.max(np.hypot(*self.points.T)))

    @property
    def inner_radius(self) -> float:
        """Radius of the largest circle around the base's origin within the polygon [m]; 0 if it is outside."""
        ends = np.roll(self.points, -1, axis=0)
        along = ends - self.points
        areas = self.points[:, 0] * ends[:, 1] - self.points[:, 1] * ends[:, 0]
        return max(0.0, float(np.min(areas / np.hypot(*along.T))))

    def distance_to_edge(self, bearing: float) -> float:
        """Return the distance from the base's origin, which is inside, to the edge in a direction [rad], [m]."""
        edges = np.roll(self.points, -1, axis=0) - self.points
        x, y = np.cos(bearing), np.sin(bearing)
        across = x * edges[:, 1] - y * edges[:, 0]  # positive for edges ahead
        areas = self.points[:, 0] * edges[:, 1] - self.points[:, 1] * edges[:, 0]
        ahead = across > 0.0
        return float(np.min(areas[ahead] / across[ahead]))

    def contains(self, point: Corner) -> bool:
        """Whether a point is within the polygon or on its edge."""
        edges, away = np.roll(self.points, -1, axis=0) - self.points, np.subtract(point, self.points)
        return bool(np.min(edges[:, 0] * away[:, 1] - edges[:, 1] * away[:, 0]) >= 0.0)


def read_footprint(value: object) -> object:
    """Read a footprint from a list of corners; other values are returned unchanged.

    Raises:
        ValueError: They are not the corners of a convex polygon, counterclockwise.
    """
    if not isinstance(value, list | tuple):
        return value
    corners = CORNERS.validate_python(value)
    points = np.array(corners)
    edges = np.roll(points, -1, axis=0) - points
    following = np.roll(edges, -1, axis=0)
    turns = edges[:, 0] * following[:, 1] - edges[:, 1] * following[:, 0]
    bends = np.arctan2(turns, np.sum(edges * following, axis=1))
    if np.min(turns) <= 0.0 or abs(float(np.sum(bends)) - 2.0 * np.pi) > 1e-6:
        raise ValueError("expected the corners of a convex polygon, counterclockwise")
    return Footprint(corners)


def convex_footprint(points: Array) -> Footprint:
    """Return the convex hull of points; one with more than `MAX_CORNERS` corners is enlarged to fewer.

    Args:
        points: Points in the frame of the base, shape (n, 2) [m].

    Raises:
        ValueError: The points enclose no area.
    """
    hull = _without_flat_corners(_hull(points))
    while len(hull) > MAX_CORNERS:
        hull = _without_shortest_edge(hull)
    return Footprint(tuple((round(x, 4), round(y, 4)) for x, y in hull.tolist()))


def _hull(points: Array) -> Array:
    from scipy.spatial import ConvexHull, QhullError  # noqa: PLC0415 - slow to load, and declared footprints need none

    try:
        found = ConvexHull(points)
    except QhullError as error:
        raise ValueError("the points of a footprint enclose no area") from error
    if found.volume < FLATTEST:
        raise ValueError(f"invalid area {found.volume:.3g} m^2 of a footprint; expected {FLATTEST:g} m^2 or more")
    corners: Array = points[found.vertices]
    return corners


def _without_flat_corners(corners: Array) -> Array:
    """Remove corners that are almost on the line between their neighbours."""
    index = 0
    while index < len(corners) and len(corners) > MIN_CORNERS:
        start, here, end = (corners[(index + step) % len(corners)] for step in (-1, 0, 1))
        along, away = end - start, here - start
        if abs(along[0] * away[1] - along[1] * away[0]) <= FLAT * np.hypot(*along):
            corners = np.delete(corners, index, axis=0)
        else:
            index += 1
    return corners


def _without_shortest_edge(corners: Array) -> Array:
    """Replace an edge by the intersection of its neighbours, which contains all; the edge that adds least area."""
    best, added = corners, np.inf
    for index in range(len(corners)):
        before, start, end, after = (corners[(index + step) % len(corners)] for step in (-1, 0, 1, 2))
        one, other = start - before, end - after
        cross = one[0] * other[1] - one[1] * other[0]
        gap = end - start
        along = (gap[0] * other[1] - gap[1] * other[0]) / cross if cross else -1.0
        if along <= 0.0:  # the neighbours diverge
            continue
        tip = start + along * one
        area = abs(gap[0] * (tip - start)[1] - gap[1] * (tip - start)[0]) / 2.0
        if area < added:
            kept = np.roll(corners, -index, axis=0)
            best, added = np.vstack([tip, kept[2:]]), area
    return best
