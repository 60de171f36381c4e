"""Parsed models, kept until they are too large together."""

from __future__ import annotations

import hashlib
from collections import OrderedDict
from collections.abc import Callable, Mapping

from sim_nodes.models.scenes import SceneBody
from sim_nodes.physics import BodyModel, Hull

Bodies = tuple[SceneBody, ...]


class ModelCache:
    """The bodies of files that were used last; they depend on the files alone, so results do not depend on it.

    Args:
        limit: Size of all models together [bytes].
    """

    def __init__(self, limit: int) -> None:
        self._limit = limit
        self._models: OrderedDict[bytes, Bodies] = OrderedDict()
        self._size = 0

    def get(self, key: bytes, parse: Callable[[], Bodies]) -> Bodies:
        """Return the bodies of a key, see `key_of`; unknown ones are parsed."""
        if key in self._models:
            self._models.move_to_end(key)
            return self._models[key]
        found = parse()
        size = _size(found)
        if size <= self._limit:
            self._models[key] = found
            self._size += size
        while self._size > self._limit:
            _, oldest = self._models.popitem(last=False)
            self._size -= _size(oldest)
        return found


def key_of(text: str, files: Mapping[str, bytes], *settings: object) -> bytes:
    """Return the key of a file with the files that it names, and settings of the reader."""
    digest = hashlib.sha256(repr((text, *settings)).encode())
    for path, data in sorted(files.items()):
        digest.update(repr((path, len(data))).encode())
        digest.update(data)
    return digest.digest()


def _size(bodies: Bodies) -> int:
    return sum(_size_of(body.model) for body in bodies)


def _size_of(model: BodyModel) -> int:
    """Return the size of a model [bytes]; shapes besides hulls and short texts count little."""
    size = sum(len(part.shape.data) for part in model.parts if isinstance(part.shape, Hull))
    if model.urdf is not None:
        size += len(model.urdf.text) + sum(map(len, model.urdf.meshes.values()))
    if model.mjcf is not None:
        size += len(model.mjcf.text) + sum(map(len, model.mjcf.assets.values()))
    return size
