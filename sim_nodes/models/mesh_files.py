"""Files of a canonical model: its meshes, with their pictures."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from seoro.bridges.model_files import virtual_path
from seoro.deferred import dataclass
from sim_nodes.geometry import Vector
from sim_nodes.models import xml_reading as xml
from sim_nodes.models.decomposition import decomposed
from sim_nodes.models.meshes import Mesh, find_picture, hull, load_pieces, to_stl, with_picture
from sim_nodes.models.obj import to_obj
from sim_nodes.models.primitives import surface_of
from sim_nodes.models.settings import ModelSettings
from sim_nodes.models.urdf import SCALES, read_numbers
from sim_nodes.physics import Hull, Shape
from sim_nodes.views import Colour


@dataclass(frozen=True)
class MeshFile:
    """A mesh in a file of its own.

    Attributes:
        name: Name of the file.
        hull: Its convex hull, if it is solid.
        colour: Its main colour; None without one.
        picture: Name of the file of its picture; None without one.
        concave: Whether it is solid as it is, not as its convex hull: a height field that never moves.
    """

    name: str
    hull: Hull | None
    colour: Colour | None
    picture: str | None
    concave: bool = False


class MeshFiles:
    """Writes the meshes of a model.

    Args:
        files: Files of the model by virtual path.
        settings: Settings of the reader.
        note: Called with texts on parts without effect.

    Attributes:
        written: Meshes and pictures by file name.
    """

    def __init__(self, files: Mapping[str, bytes], settings: ModelSettings, note: Callable[[str], None]) -> None:
        self._files, self._settings, self._note = files, settings, note
        self._meshes: dict[tuple[str, Vector, bool, str | None], list[MeshFile]] = {}
        self._pictures: dict[bytes, str] = {}
        self.written: dict[str, bytes] = {}

    def write(self, shape: Any, what: str, *, solid: bool, texture: str | None) -> list[MeshFile]:
        """Write the pieces of a mesh, once.

        Args:
            shape: The <mesh> element.
            what: Text for the element around it in messages.
            solid: Whether the pieces are convex, to collide; else they are to be seen.
            texture: Virtual path of the picture that replaces those of the mesh; None for them.
        """
        path = virtual_path(shape.get("filename") or "")
        scale = read_numbers(shape.get("scale", "1 1 1"), f"scale of the mesh in {what}", None, SCALES)[:3]
        if len(scale) == 1:
            scale *= 3
        if len(scale) != 3:
            raise xml.invalid(f"invalid scale of the mesh in {what}: {shape.get('scale')!r}; expected 3 numbers")
        key = (path, (scale[0], scale[1], scale[2]), solid, texture)
        if key not in self._meshes:
            self._meshes[key] = self._load(*key, what)
        return self._meshes[key]

    def write_picture(self, shape: Shape, texture: str) -> MeshFile | None:
        """Write the surface of a shape with a picture, by its virtual path; None if it cannot show it."""
        surface, picture = surface_of(shape), find_picture(self._files, texture, self._note)
        if surface is None or picture is None or self._settings.colour is not None:
            return None
        return self._add_visual(with_picture(surface, picture))

    def write_field(self, shape: Any) -> MeshFile:
        """Write the mesh of a height field as it is; its hull is that of the whole field."""
        path = virtual_path(shape.get("filename") or "")
        [piece] = load_pieces(self._files, path, (1.0, 1.0, 1.0), solid=False, note=self._note)
        whole = Hull(hull(piece).vertices.astype("<f8").tobytes())
        return MeshFile(self._add_stl(piece), whole, None, None, concave=True)

    def _load(self, path: str, scale: Vector, solid: bool, texture: str | None, what: str) -> list[MeshFile]:
        pieces = load_pieces(self._files, path, scale, solid=solid, note=self._note)
        if solid:
            if self._settings.decompose:
                pieces = [convex for piece in pieces for convex in decomposed(piece)]
            return [self._add_solid(hull(piece)) for piece in pieces]
        if texture is not None:
            pieces = self._textured(pieces, texture, what)
        return [self._add_visual(piece) for piece in pieces]

    def _textured(self, pieces: list[Mesh], texture: str, what: str) -> list[Mesh]:
        """Return pieces with another picture, if there is one."""
        picture = find_picture(self._files, texture, self._note)
        if picture is None:
            return pieces
        if any(piece.coordinates is None for piece in pieces):
            self._note(f"without effect: <texture> of {what}, whose mesh has no texture coordinates")
        return [with_picture(piece, picture) for piece in pieces]

    def _add_solid(self, mesh: Mesh) -> MeshFile:
        return MeshFile(self._add_stl(mesh), Hull(mesh.vertices.astype("<f8").tobytes()), mesh.colour, None)

    def _add_visual(self, mesh: Mesh) -> MeshFile:
        if mesh.picture is None or self._settings.colour is not None:
            return MeshFile(self._add_stl(mesh), None, mesh.colour, None)
        picture = self._add_picture(mesh.picture)
        name = f"mesh{len(self.written)}.obj"
        self.written[name] = to_obj(mesh)
        return MeshFile(name, None, mesh.colour, picture)

    def _add_stl(self, mesh: Mesh) -> str:
        name = f"mesh{len(self.written)}.stl"
        self.written[name] = to_stl(mesh)
        return name

    def _add_picture(self, picture: bytes) -> str:
        if picture not in self._pictures:
            name = self._pictures[picture] = f"picture{len(self._pictures)}.png"
            self.written[name] = picture
        return self._pictures[picture]
