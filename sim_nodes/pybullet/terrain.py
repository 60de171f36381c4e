"""Terrain in PyBullet: a static body for each piece, which is one shape, so that states can be rewound."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from sim_nodes.geometry import Array, quaternion
from sim_nodes.physics import BodyState, Box, Part
from sim_nodes.pybullet.model import BASE, xyzw
from sim_nodes.terrain.ground import Ground, HeightField, Slab
from sim_nodes.views import TERRAIN

SIDES = ((1, 5, 7, 3), (0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6))
FACES = np.array(
    [face for a, b, c, d in SIDES for face in ((a, b, c), (a, c, d))]
)  # of a slab but its bottom, by its points


def add_terrain(bullet: Any, ground: Ground) -> Iterator[tuple[int, Part, BodyState]]:
    """Add the terrain of a scene; yields the number of each body, a box around it in its frame, and its state."""
    for piece in ground.pieces:
        # The origins of boxes and height fields are at half of their heights.
        origin = piece.top / 2 if isinstance(piece, HeightField) or piece.is_level else 0.0
        state = BodyState((piece.place.x, piece.place.y, origin), quaternion(0.0, 0.0, piece.place.yaw))
        with tempfile.TemporaryDirectory(prefix="seoro-") as folder:  # Bullet reads the files for each body
            path = Path(folder) / "terrain.obj"
            path.write_text(_obj(_triangles(piece)))
            # Bullet never frees meshes that it gets as lists.
            visual = bullet.createVisualShape(bullet.GEOM_MESH, fileName=str(path), rgbaColor=TERRAIN)
            shape = _solid(bullet, piece, path)
            body: int = bullet.createMultiBody(0.0, shape, visual, state.position, xyzw(state.orientation))
        bullet.changeDynamics(body, BASE, lateralFriction=ground.friction_of(piece))
        yield body, Part(Box((piece.length, piece.width, piece.top)), (0.0, 0.0, piece.top / 2 - origin)), state


def _solid(bullet: Any, piece: Slab | HeightField, path: Path) -> int:
    """Create the collision shape of a piece, whose mesh is in a file."""
    if isinstance(piece, HeightField):
        shape: int = bullet.createCollisionShape(
            bullet.GEOM_HEIGHTFIELD,
            meshScale=[*piece.spacing, 1.0],
            heightfieldTextureScaling=1.0,
            heightfieldData=piece.grid.ravel().tolist(),
            numHeightfieldRows=piece.columns,
            numHeightfieldColumns=piece.rows,
        )
        return shape
    if piece.is_level:
        half = [piece.length / 2, piece.width / 2, piece.top / 2]
        shape = bullet.createCollisionShape(bullet.GEOM_BOX, halfExtents=half)
    else:
        shape = bullet.createCollisionShape(bullet.GEOM_MESH, fileName=str(path))  # its convex hull
    return shape


def _triangles(piece: Slab | HeightField) -> Array:
    """Return the surface of a piece in the frame of its body, shape (n, 3 corners, 3) [m]."""
    if isinstance(piece, Slab):
        lift = piece.top / 2 if piece.is_level else 0.0
        drawn: Array = (piece.points - (0.0, 0.0, lift))[FACES]
        return drawn
    along = np.linspace(-piece.length / 2, piece.length / 2, piece.columns)
    across = np.linspace(-piece.width / 2, piece.width / 2, piece.rows)
    xs, ys = np.meshgrid(along, across)
    points = np.stack([xs, ys, piece.grid - piece.top / 2], axis=-1)
    first, ahead, beside, second = points[:-1, :-1], points[:-1, 1:], points[1:, :-1], points[1:, 1:]
    cells = [
        np.stack(each, axis=2).reshape(-1, 3, 3) for each in ((first, ahead, beside), (ahead, second, beside))
    ]
    return np.concatenate(cells)


def _obj(triangles: Array) -> str:
    """Return triangles as a file in OBJ, with the normal of each."""
    across = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    length = np.linalg.norm(across, axis=1)
    whole = length > 0.0
    normals = across[whole] / length[whole, None]
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in triangles[whole].reshape(-1, 3).tolist()]
    lines += [f"vn {x:.6g} {y:.6g} {z:.6g}" for x, y, z in normals.tolist()]
    for face in range(1, len(normals) + 1):
        lines.append("f " + " ".join(f"{3 * face - corner}//{face}" for corner in (2, 1, 0)))
    return "\n".join(lines)
