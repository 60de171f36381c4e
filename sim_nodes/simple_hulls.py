"""Convex hulls with few corners, to draw them."""

from __future__ import annotations

from functools import lru_cache
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim_nodes.bodies import Hull
from sim_nodes.geometry import Array

FLAT = 1e-4  # [m] of the thinnest hull with faces
DIRECTIONS: Array = np.array([each for each in product((-1.0, 0.0, 1.0), repeat=3) if any(each)])


class SimpleHull(NamedTuple):
    """Corners, shape (n, 3) [m], and triangles of their indices, shape (m, 3), counterclockwise from outside."""

    corners: Array
    triangles: NDArray[np.uint8]


@lru_cache(maxsize=1024)
def simplified(hull: Hull) -> SimpleHull | None:
    """Return the hull of the outermost points in 26 directions; None for a flat hull.

    Args:
        hull: The hull.
    """
    from scipy.spatial import ConvexHull, QhullError  # noqa: PLC0415 - slow to load, and large

    points = hull.points
    scaled = points / np.maximum(np.ptp(points, axis=0), FLAT)  # as if it were as high as long and wide
    corners = points[np.unique(np.argmax(scaled @ DIRECTIONS.T, axis=0))]
    try:
        found = ConvexHull(corners)
    except QhullError:
        return None
    if found.volume < FLAT * found.area / 2.0:
        return None
    triangles = found.simplices
    a, b, c = (corners[triangles[:, index]] for index in range(3))
    is_inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), found.equations[:, :3]) < 0.0
    triangles[is_inward] = triangles[is_inward][:, ::-1]
    used, renumbered = np.unique(triangles, return_inverse=True)
    return SimpleHull(corners[used], renumbered.reshape(-1, 3).astype(np.uint8))
