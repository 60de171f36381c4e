"""Scenes of nodes as records of a trace."""

from __future__ import annotations

import zlib
from base64 import b64encode
from typing import Any

from seoro.bridges import wire
from seoro.runtime.contracts.tracks import SceneChange

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
    return {**entity.model_dump(exclude={"shapes"}), "shapes": [_plain_shape(shape) for shape in entity.shapes]}


def _plain_shape(shape: wire.SceneShape) -> dict[str, Any]:
    return shape.model_dump(exclude_defaults=True)


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
