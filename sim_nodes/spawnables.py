"""Models that can be spawned: models on the model path and in given folders, and props of the world."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from seoro.bridges.models import ModelNotFound, ModelPath
from seoro.bridges.wire import SpawnResult
from seoro.bridges.wire.refusal import RequestRefused, name_list
from seoro.files.inputs import Kind, read_input_text
from sim_nodes.extents import BoundingBox, bounding_box
from sim_nodes.files import FILE, list_files
from sim_nodes.models import parse_model
from sim_nodes.physics import BodyModel
from sim_nodes.worlds.loader import World

SUFFIXES = frozenset({".sdf", ".urdf", ".xml", ".mjcf"})
PROP = "prop://"


@dataclass(frozen=True)
class SpawnableModel:
    """A model that can be spawned."""

    uri: str
    description: str
    bounds: BoundingBox


def model_of(uri: str, models: ModelPath, world: World) -> BodyModel:
    """Return the model of a URI: a prop of the world, or a file.

    Raises:
        RequestRefused: The model is unknown, or cannot be simulated.
    """
    if uri.startswith(PROP):
        props = {prop.name: prop.model for prop in world.props}
        name = uri.removeprefix(PROP)
        if name not in props:
            raise RequestRefused(
                SpawnResult.NO_RESOURCE, f"unknown prop {name!r} of the world; props: {name_list(props)}"
            )
        return props[name]
    try:
        text = models.read(uri)
    except ModelNotFound as error:
        raise RequestRefused(SpawnResult.NO_RESOURCE, str(error)) from error
    return parse_model(text)


def find_spawnables(models: ModelPath, world: World, sources: Sequence[str]) -> tuple[list[SpawnableModel], str]:
    """List all models that can be simulated, and describe problems, one sentence each."""
    files, problems = list_files(models.files(SUFFIXES), sources, SUFFIXES, FILE)
    return [*_props(world), *_simulable(files)], problems


def _props(world: World) -> Iterator[SpawnableModel]:
    for prop in world.props:
        yield _found(f"{PROP}{prop.name}", f"prop {prop.name} of the world", prop.model)


def _simulable(files: Iterable[tuple[str, Path]]) -> Iterator[SpawnableModel]:
    for uri, path in files:
        try:
            model = parse_model(read_input_text(path, Kind.MODEL))
        except (RequestRefused, OSError, UnicodeDecodeError):  # it cannot be spawned
            continue
        yield _found(uri, path.name, model)


def _found(uri: str, what: str, model: BodyModel) -> SpawnableModel:
    bounds = bounding_box(model.parts)
    assert bounds is not None, "models have parts"
    return SpawnableModel(uri, f"{what}, {'fixed' if model.static else f'{model.mass:g} kg'}", bounds)
