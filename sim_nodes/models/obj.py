"""OBJ, the format of meshes with pictures in canonical models."""

from __future__ import annotations

from collections.abc import Iterator

from sim_nodes.geometry import Array
from sim_nodes.models.meshes import Mesh


def to_obj(mesh: Mesh) -> bytes:
    """Return a mesh with texture coordinates as an OBJ file."""
    assert mesh.coordinates is not None, "only meshes with pictures are written in OBJ"
    lines = [
        *_lines("v", mesh.vertices),
        *_lines("vt", mesh.coordinates),
        *(f"f {a}/{a} {b}/{b} {c}/{c}" for a, b, c in (mesh.faces + 1).tolist()),
    ]
    return "\n".join([*lines, ""]).encode()


def _lines(key: str, rows: Array) -> Iterator[str]:
    return (f"{key} {' '.join(map(repr, row))}" for row in rows.tolist())
