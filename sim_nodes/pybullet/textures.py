"""Pictures on the meshes of bodies in Bullet."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from sim_nodes.models.urdf import pictures_of


class Textures:
    """The textures of one world, each loaded once: Bullet frees them with the world only.

    Args:
        bullet: The Bullet client.
    """

    def __init__(self, bullet: Any) -> None:
        self._bullet = bullet
        self._numbers: dict[bytes, int] = {}

    def show(self, body: int, urdf: Any, files: Mapping[str, bytes], links: Mapping[int, str]) -> None:
        """Show the pictures of a body.

        Args:
            body: Number of the body.
            urdf: Root element of its URDF.
            files: Meshes and pictures by file name.
            links: Names of its links by index.
        """
        pictures = pictures_of(urdf)
        if not pictures:
            return
        visuals = {link.get("name"): link.findall("visual") for link in urdf.findall("link")}
        for index, name in links.items():
            for shape, visual in enumerate(visuals[name]):
                mesh = visual.find("geometry/mesh")
                if mesh is not None and mesh.get("filename") in pictures:
                    number = self._number(files[pictures[mesh.get("filename")]])
                    self._bullet.changeVisualShape(body, index, shape, textureUniqueId=number)

    def _number(self, picture: bytes) -> int:
        if picture not in self._numbers:
            with tempfile.NamedTemporaryFile(suffix=".png") as file:
                Path(file.name).write_bytes(picture)
                self._numbers[picture] = self._bullet.loadTexture(file.name)
        return self._numbers[picture]
