"""Meshes of models: STL, OBJ and DAE files as triangles, by trimesh.

Engines get copies in STL, of which solid ones are convex: each engine reads other formats, and other parts of
them. Lengths are in metres, after the scale of the model and the unit of the file.
"""

from __future__ import annotations

import io
import posixpath
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Any

import numpy as np
import trimesh
from scipy.spatial import QhullError
from trimesh.exchange.stl import export_stl

from sim_nodes.geometry import Array, Vector
from sim_nodes.models.xml_reading import invalid
from sim_nodes.views import Colour

FORMATS = {
    ".stl": "stl",
    ".stlb": "stl",
    ".obj": "obj",
    ".dae": "dae",
    ".ply": "ply",
    ".glb": "glb",
    ".off": "off",
}
MAX_FACES = 200_000  # of a mesh; MuJoCo's limit for STL
THINNEST = 1e-4  # [m] of a solid shape; flat ones get this thickness


@dataclass(frozen=True)
class Mesh:
    """Triangles: vertices of shape (n, 3) [m], corners of faces of shape (m, 3), and perhaps a colour."""

    vertices: Array
    faces: Any
    colour: Colour | None = None


def load_pieces(files: Mapping[str, bytes], path: str, scale: Vector, *, solid: bool) -> list[Mesh]:
    """Load the pieces of a mesh file.

    Args:
        files: Files of the model by virtual path.
        path: Virtual path of the file.
        scale: Factors along x, y and z.
        solid: Whether the pieces are the objects of the file, for solid shapes; else they differ in colour.

    Raises:
        RequestRefused: The file is missing, of an unknown format, damaged or too large.
    """
    suffix = PurePosixPath(path).suffix.lower()
    if suffix not in FORMATS:
        raise invalid(f"unsupported format of the mesh {path!r}; expected {', '.join(FORMATS)}")
    if path not in files:
        raise invalid(f"missing mesh {path!r}; expected it among the files of the model")
    of_objects: dict[str, Any] = {"split_objects": solid, "skip_materials": solid} if suffix == ".obj" else {}
    try:
        scene = trimesh.load_scene(
            io.BytesIO(files[path]),
            file_type=FORMATS[suffix],
            resolver=_Resolver(files, posixpath.dirname(path)),
            process=False,
            **of_objects,
        )
        if scene.units not in (None, "meters"):  # given by DAE
            scene = scene.convert_units("meters")
        pieces = [each for each in scene.dump() if isinstance(each, trimesh.Trimesh) and len(each.faces)]
    except Exception as error:  # each format has its own exceptions
        # Without the text of the error, which may quote the file: a model may name any file of this machine.
        raise invalid(f"the mesh {path!r} is damaged, or not in its format ({type(error).__name__})") from error
    if not pieces:
        raise invalid(f"the mesh {path!r} has no triangles")
    if sum(len(each.faces) for each in pieces) > MAX_FACES:
        raise invalid(f"the mesh {path!r} has more than {MAX_FACES} triangles; simplify it")
    meshes = [Mesh(np.asarray(each.vertices) * scale, np.asarray(each.faces), _colour(each)) for each in pieces]
    if not solid:
        meshes = _by_colour(meshes)
    if not all(np.all(np.isfinite(mesh.vertices)) for mesh in meshes):
        raise invalid(f"the mesh {path!r} has coordinates that are not finite")
    return meshes


def _by_colour(meshes: Sequence[Mesh]) -> list[Mesh]:
    """Join meshes of the same colour."""
    groups: dict[Colour | None, list[Mesh]] = {}
    for mesh in meshes:
        groups.setdefault(mesh.colour, []).append(mesh)
    joined = []
    for colour, group in groups.items():
        starts = np.cumsum([0, *(len(mesh.vertices) for mesh in group[:-1])])
        faces = np.vstack([mesh.faces + start for mesh, start in zip(group, starts, strict=True)])
        joined.append(Mesh(np.vstack([mesh.vertices for mesh in group]), faces, colour))
    return joined


class _Resolver(trimesh.resolvers.Resolver):
    """Finds materials and textures among the files of a model."""

    def __init__(self, files: Mapping[str, bytes], folder: str) -> None:
        self._files, self._folder = files, folder

    def get(self, name: str) -> bytes:
        """Return a file by its name in the mesh."""
        return self._files[posixpath.normpath(posixpath.join(self._folder, name))]

    def keys(self) -> Iterable[str]:
        """Return the names of all files."""
        return self._files.keys()

    def write(self, name: str, data: bytes) -> None:
        """Refuse writing."""
        raise NotImplementedError

    def namespaced(self, namespace: str) -> _Resolver:
        """Return a resolver for a folder."""
        return _Resolver(self._files, posixpath.join(self._folder, namespace))


def _colour(mesh: trimesh.Trimesh) -> Colour | None:
    """Return the main colour of a mesh; None if its file has none."""
    if not isinstance(mesh.visual, trimesh.visual.TextureVisuals) or mesh.visual.material is None:
        return None
    red, green, blue, opacity = (float(value) / 255.0 for value in mesh.visual.material.main_color)
    return red, green, blue, opacity or 1.0


def hull(mesh: Mesh) -> Mesh:
    """Return the convex hull of a mesh; a flat one is thickened.

    Raises:
        RequestRefused: The mesh has no extent.
    """
    vertices = np.unique(mesh.vertices, axis=0)
    for grown in (vertices, _thickened(vertices)):
        try:
            convex = trimesh.Trimesh(grown).convex_hull if len(grown) > 3 else None
        except QhullError:
            convex = None
        if convex is not None and convex.volume > 0.0:
            return Mesh(np.asarray(convex.vertices), np.asarray(convex.faces), mesh.colour)
    raise invalid("a mesh without extent cannot be solid")


def _thickened(vertices: Array) -> Array:
    half = THINNEST / 2
    return np.vstack([vertices + offset for offset in half * np.vstack([np.eye(3), -np.eye(3)])])


def to_stl(mesh: Mesh) -> bytes:
    """Return a mesh as a binary STL file."""
    return export_stl(trimesh.Trimesh(mesh.vertices, mesh.faces, process=False))
