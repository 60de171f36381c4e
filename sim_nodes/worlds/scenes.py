"""Scenes: model files whose bodies are props of a world."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from seoro.bridges.model_files import InvalidModel, gather
from seoro.bridges.wire.refusal import RequestRefused
from seoro.deferred import dataclass
from seoro.files.yaml_lines import FileError
from sim_nodes.extents import highest_of, outline
from sim_nodes.models.scenes import split_scene
from sim_nodes.worlds.props import Prop
from sim_nodes.worlds.schema import check_extent
from sim_nodes.worlds.surroundings import FLUSH

MARGIN = 1.0  # [m] of floor around the bodies of a scene


@dataclass(frozen=True)
class WorldScene:
    """Bodies of a scene as props; `extent` covers all that is higher than the floor [m]."""

    props: tuple[Prop, ...]
    extent: tuple[float, float, float, float]


def read_scene(scene: str, folder: Path) -> WorldScene:
    """Read a scene.

    Args:
        scene: Name of an SDF, MJCF or URDF file.
        folder: Folder that relative names start from.

    Raises:
        FileError: The file is unreadable or invalid, or the scene is too large.
    """
    try:
        found = gather(folder / scene, expands=True)
        bodies = split_scene(found.text, found.files)
    except InvalidModel as error:
        raise FileError(f"scene: {error}") from error
    except RequestRefused as error:
        raise FileError(f"scene: {scene}: {error.message}") from error
    props = tuple(Prop(body.name, body.model, body.state) for body in bodies)
    return WorldScene(props, _extent(props, scene))


def _extent(props: tuple[Prop, ...], scene: str) -> tuple[float, float, float, float]:
    corners = [
        outline(part, prop.state)
        for prop in props
        for part in prop.model.parts
        if highest_of(part, prop.state) > FLUSH
    ]
    points = np.concatenate(corners) if corners else np.zeros((1, 2))
    left, bottom = np.floor(points.min(axis=0) - MARGIN).tolist()
    right, top = np.ceil(points.max(axis=0) + MARGIN).tolist()
    try:
        check_extent((left, bottom, right, top))
    except ValueError as error:
        raise FileError(f"scene: {scene}: {error}; give `extent` in a world file with this `scene`") from error
    return left, bottom, right, top
