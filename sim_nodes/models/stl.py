"""Binary STL, the format of meshes in canonical models."""

from __future__ import annotations

import numpy as np

from sim_nodes.physics import Hull

HEADER = 84  # [bytes]
TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def hull_of_stl(data: bytes) -> Hull:
    """Return the convex hull of a mesh in binary STL that is convex."""
    corners = np.frombuffer(data, TRIANGLE, offset=HEADER)["corners"].reshape(-1, 3)
    return Hull(np.unique(corners, axis=0).astype("<f8").tobytes())
