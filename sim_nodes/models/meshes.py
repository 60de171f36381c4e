"""Meshes of models: STL, OBJ and DAE files as triangles, by trimesh.

Engines get copies in STL, of which solid ones are convex, or in OBJ with a picture: each engine reads other
formats, and other parts of them. Lengths are in metres, after the scale of the model and the unit of the file.
"""

from __future__ import annotations

import io
import posixpath
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import PurePosixPath
from typing import Any

import numpy as np
import trimesh
from PIL.Image import Image
from scipy.spatial import QhullError
from trimesh.exchange.stl import export_stl
from trimesh.visual.material import PBRMaterial, SimpleMaterial

from seoro.bridges.model_files import virtual_path
from seoro.deferred import dataclass
from sim_nodes.geometry import Array, Vector
from sim_nodes.models.pictures import UnusablePicture, mean_colour, read_picture, to_png
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
PICTURES = {".png", ".jpg", ".jpeg", ".bmp", ".tga", ".gif", ".tif", ".tiff"}
THINNEST = 1e-4  # [m] of a solid shape; flat ones get this thickness


@dataclass(frozen=True)
class Mesh:
    """Triangles.

    Attributes:
        vertices: Shape (n, 3) [m].
        faces: Numbers of their corners, shape (m, 3).
        colour: Main colour; None without one.
        coordinates: Places of the vertices in a picture, whose lower left corner is (0, 0) and whose upper right
            corner is (1, 1), shape (n, 2); None without any.
        picture: Picture of the mesh file itself, in PNG; only with `coordinates`.
    """

    vertices: Array
    faces: Any
    colour: Colour | None = None
    coordinates: Array | None = None
    picture: bytes | None = None


def load_pieces(
    files: Mapping[str, bytes], path: str, scale: Vector, *, solid: bool, note: Callable[[str], None]
) -> list[Mesh]:
    """Load the pieces of a mesh file.

    Args:
        files: Files of the model by virtual path.
        path: Virtual path of the file.
        scale: Factors along x, y and z.
        solid: Whether the pieces are the objects of the file, for solid shapes; else they differ in colour or
            picture.
        note: Called with texts on pictures without effect.

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
            resolver=_Resolver(files, posixpath.dirname(path), note),
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
    meshes = [_mesh(each, scale, solid=solid) for each in pieces]
    if not solid:
        meshes = _by_appearance(meshes)
    if not all(np.all(np.isfinite(mesh.vertices)) for mesh in meshes):
        raise invalid(f"the mesh {path!r} has coordinates that are not finite")
    return meshes


def _mesh(piece: trimesh.Trimesh, scale: Vector, *, solid: bool) -> Mesh:
    vertices, faces, visual = np.asarray(piece.vertices) * scale, np.asarray(piece.faces), piece.visual
    if not isinstance(visual, trimesh.visual.TextureVisuals) or visual.material is None:
        return Mesh(vertices, faces)
    red, green, blue, opacity = (float(value) / 255.0 for value in visual.material.main_color)
    colour: Colour = (red, green, blue, opacity or 1.0)
    if solid or visual.uv is None or len(visual.uv) != len(vertices) or not np.all(np.isfinite(visual.uv)):
        return Mesh(vertices, faces, colour)
    coordinates = np.asarray(visual.uv, dtype=np.float64)
    match visual.material:
        case SimpleMaterial(image=Image() as image) | PBRMaterial(baseColorTexture=Image() as image):
            picture = to_png(image)
            return Mesh(vertices, faces, mean_colour(picture), coordinates, picture)
    return Mesh(vertices, faces, colour, coordinates)


def find_picture(files: Mapping[str, bytes], path: str, note: Callable[[str], None]) -> bytes | None:
    """Return a picture among the files of a model in PNG, small; None with a note if it is missing or unusable.

    Args:
        files: Files of the model by virtual path.
        path: Virtual path of the picture.
        note: Called with the reason.
    """
    if path not in files:
        note(f"without effect: the picture {path!r} is missing")
        return None
    try:
        return to_png(read_picture(files[path]))
    except UnusablePicture as error:
        note(f"without effect: the picture {path!r} {error}")
        return None


def with_picture(mesh: Mesh, picture: bytes) -> Mesh:
    """Return a mesh with another picture in PNG; one without texture coordinates stays as it is."""
    return mesh if mesh.coordinates is None else replace(mesh, picture=picture, colour=mean_colour(picture))


def _by_appearance(meshes: Sequence[Mesh]) -> list[Mesh]:
    """Join meshes of the same colour and picture."""
    groups: dict[tuple[Colour | None, bytes | None, bool], list[Mesh]] = {}
    for mesh in meshes:
        groups.setdefault((mesh.colour, mesh.picture, mesh.coordinates is None), []).append(mesh)
    joined = []
    for (colour, picture, _), group in groups.items():
        starts = np.cumsum([0, *(len(mesh.vertices) for mesh in group[:-1])])
        faces = np.vstack([mesh.faces + start for mesh, start in zip(group, starts, strict=True)])
        coordinates = [mesh.coordinates for mesh in group if mesh.coordinates is not None]
        vertices = np.vstack([mesh.vertices for mesh in group])
        joined.append(Mesh(vertices, faces, colour, np.vstack(coordinates) if coordinates else None, picture))
    return joined


class _Resolver(trimesh.resolvers.Resolver):
    """Finds materials and pictures among the files of a model; pictures are small, and in PNG."""

    def __init__(self, files: Mapping[str, bytes], folder: str, note: Callable[[str], None]) -> None:
        self._files, self._folder, self._note = files, folder, note

    def get(self, name: str) -> bytes:
        """Return a file by its name in the mesh, which options may precede."""
        named = name.rsplit(maxsplit=1)[-1] if name.startswith("-") else name
        path = virtual_path(named, self._folder)
        if PurePosixPath(path).suffix.lower() not in PICTURES:
            return self._files[path]
        picture = find_picture(self._files, path, self._note)
        if picture is None:
            raise KeyError(name)
        return picture

    def keys(self) -> Iterable[str]:
        """Return the names of all files."""
        return self._files.keys()

    def write(self, name: str, data: bytes) -> None:
        """Refuse writing."""
        raise NotImplementedError

    def namespaced(self, namespace: str) -> _Resolver:
        """Return a resolver for a folder."""
        return _Resolver(self._files, posixpath.join(self._folder, namespace), self._note)


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
