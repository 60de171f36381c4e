"""Lists of available worlds, and of models that can be spawned, in files and in folders that requests name."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

import numpy as np

from seoro.bridges import wire
from seoro.bridges.model_files import InvalidModel, gather
from seoro.bridges.models import ModelNotFound, ModelPath
from seoro.bridges.wire import SpawnResult
from seoro.bridges.wire.refusal import RequestRefused, name_list
from seoro.files.yaml_lines import FileError, read_text
from sim_nodes.extents import BoundingBox, bounding_box
from sim_nodes.files import FILE, list_files
from sim_nodes.messages import bounds_of
from sim_nodes.models import parse_bodies
from sim_nodes.models.scenes import SceneBody
from sim_nodes.physics import BodyState
from sim_nodes.worlds.loader import FOLDER, World, WorldError, available_worlds, read_world_file
from sim_nodes.worlds.props import Prop

SUFFIXES = frozenset({".sdf", ".urdf", ".xml", ".mjcf"})
PROP = "prop://"


def find_worlds(sources: Sequence[str]) -> tuple[list[wire.WorldInfo], str]:
    """List all worlds, and describe problems, one sentence each.

    Only world files are read; the files that they name are checked when a world is loaded.
    """
    own = ((name, FOLDER / f"{name}.yaml") for name in available_worlds())
    files, problems = list_files(own, sources, {".yaml"})
    found = []
    for source, path in files:
        with suppress(FileError, WorldError):  # such as the declaration of a robot
            file, _ = read_world_file(read_text(path), source)
            found.append(wire.WorldInfo(source=source, description=file.description, tags=file.tags))
    return found, problems


def bodies_of(uri: str, models: ModelPath, world: World) -> tuple[SceneBody, ...]:
    """Return the bodies of a URI: a prop of the world, or a file.

    Raises:
        RequestRefused: The model is unknown, or cannot be simulated.
    """
    if uri.startswith(PROP):
        props = {prop.name: prop for prop in world.props}
        name = uri.removeprefix(PROP)
        if name not in props:
            raise RequestRefused(
                SpawnResult.NO_RESOURCE, f"unknown prop {name!r} of the world; props: {name_list(props)}"
            )
        return (_body_of(props[name]),)
    try:
        found = models.read(uri)
    except ModelNotFound as error:
        raise RequestRefused(SpawnResult.NO_RESOURCE, str(error)) from error
    return parse_bodies(found.text, found.files)


def _body_of(prop: Prop) -> SceneBody:
    return SceneBody(prop.name, prop.model, BodyState((0.0, 0.0, 0.0)))


def find_spawnables(models: ModelPath, world: World, sources: Sequence[str]) -> tuple[list[wire.Spawnable], str]:
    """List all models that can be simulated, and describe problems, one sentence each."""
    files, problems = list_files(models.files(SUFFIXES), sources, SUFFIXES, FILE)
    found = [
        _spawnable(f"{PROP}{prop.name}", f"prop {prop.name} of the world", _body_of(prop)) for prop in world.props
    ]
    for uri, path in files:
        with suppress(RequestRefused, InvalidModel):  # it cannot be spawned
            model = gather(path)
            found.append(_spawnable(uri, path.name, *parse_bodies(model.text, model.files)))
    return found, problems


def _spawnable(uri: str, what: str, *bodies: SceneBody) -> wire.Spawnable:
    placed = [
        part.placed(body.state.position, body.state.orientation) for body in bodies for part in body.model.parts
    ]
    box = bounding_box(placed) or BoundingBox(np.zeros(3), np.zeros(3))  # without collision shapes
    mass = sum(body.model.mass for body in bodies if not body.model.static)
    several = f"{len(bodies)} bodies, " if len(bodies) > 1 else ""
    description = f"{what}, {several}{f'{mass:g} kg' if mass else 'fixed'}"
    bounds = bounds_of(box.lower.tolist(), box.upper.tolist())
    return wire.Spawnable(uri=uri, description=description, bounds=bounds)
