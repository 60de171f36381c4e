"""Scenes of nodes as records of a trace."""

from __future__ import annotations

import math
import zlib
from base64 import b64encode
from itertools import chain
from struct import Struct
from typing import Any

from seoro.bridges import wire
from seoro.bridges.sim.rules import ProtocolViolation
from seoro.runtime.contracts.tracks import SceneChange

_CORNER = Struct("<3f")
_TRIANGLE = Struct("<3B")
_DIGITS = 4  # of corners, after the decimal point
MAX_MAP = 512 * 1024  # [bytes] of a map in a record


def scene_change(scene: wire.Scene) -> SceneChange:
    """Return a scene as a record; a map that is too large is left out, and counted as omitted."""
    known = None if scene.map is None else _plain_map(scene.map)
    fields: dict[str, Any] = {
        "time": scene.time,
        "world": scene.world,
        "simulator": scene.simulator,
        "frame": "map",
        "extent": list(scene.extent),
        "shapes": [_plain_shape(shape) for shape in scene.shapes],
        "entities": [plain_entity(entity) for entity in scene.entities],
        "places": [place.model_dump() for place in scene.places],
        "omitted": scene.omitted + (scene.map is not None and known is None),
    }
    return SceneChange("scene", fields if known is None else {**fields, "map": known})


def plain_entity(entity: wire.SceneEntity) -> dict[str, Any]:
    """Return an entity as JSON data."""
    plain = entity.model_dump(exclude={"shapes", "links"})
    links = {"links": {link.name: list(link.pose) for link in entity.links}} if entity.links else {}
    return {**plain, **links, "shapes": [_plain_shape(shape) for shape in entity.shapes]}


def _plain_shape(shape: wire.SceneShape) -> dict[str, Any]:
    plain = shape.model_dump(exclude_defaults=True, exclude={"corners", "triangles"})
    return {**plain, **_plain_hull(shape)} if shape.corners else plain


def _plain_hull(shape: wire.SceneShape) -> dict[str, Any]:
    """Return the corners and triangles of a hull.

    Raises:
        ProtocolViolation: They are invalid.
    """
    is_whole = len(shape.corners) % _CORNER.size == len(shape.triangles) % _TRIANGLE.size == 0
    corners = list(_CORNER.iter_unpack(shape.corners)) if is_whole else []
    triangles = list(_TRIANGLE.iter_unpack(shape.triangles)) if is_whole else []
    if not all(map(math.isfinite, chain(*corners))) or max(chain(*triangles), default=0) >= len(corners):
        raise ProtocolViolation(f"the node violated the protocol: it sent an invalid hull of '{shape.entity}'")
    rounded = [[round(value, _DIGITS) for value in corner] for corner in corners]
    return {"corners": rounded, "triangles": [list(each) for each in triangles]}


def _plain_map(grid: wire.OccupancyGrid) -> dict[str, Any] | None:
    data = b64encode(zlib.compress(grid.cells)).decode()
    if len(data) > MAX_MAP:
        return None
    return {
        "resolution": grid.resolution,
        "origin": [grid.x, grid.y, 0.0],
        "width": grid.columns,
        "height": grid.rows,
        "data": data,
    }
