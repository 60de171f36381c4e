"""Models that a node finds by itself: along its model path, among the props of the world, and in given folders."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, islice
from pathlib import Path

from seoro.bridges.models import ModelNotFound, ModelPath
from seoro.bridges.wire import SpawnResult
from seoro.bridges.wire.refusal import RequestRefused, listed
from seoro.input_files import Kind, read_input_text
from sim_nodes.bounds import BoundingBox, bounding_box
from sim_nodes.models import parse_model
from sim_nodes.physics import BodyModel
from sim_nodes.sources import FILE, files_of, folders_of
from sim_nodes.worlds.loader import World

MAX_FILES = 1000  # that are looked at for one list
SUFFIXES = frozenset({".sdf", ".urdf", ".xml", ".mjcf"})
PROP = "prop://"


@dataclass(frozen=True)
class Found:
    """A model that can be spawned."""

    uri: str
    description: str
    bounds: BoundingBox


def model_of(uri: str, models: ModelPath, world: World) -> BodyModel:
    """The model of a URI: of a prop of the world, or in a file.

    Raises:
        RequestRefused: There is none, or it cannot be simulated.
    """
    if uri.startswith(PROP):
        props = {prop.name: prop.model for prop in world.props}
        name = uri.removeprefix(PROP)
        if name not in props:
            raise RequestRefused(
                SpawnResult.NO_RESOURCE, f"the world has no prop {name!r}: it has {listed(props)}"
            )
        return props[name]
    try:
        text = models.read(uri)
    except ModelNotFound as error:
        raise RequestRefused(SpawnResult.NO_RESOURCE, str(error)) from error
    return parse_model(text)


def find_spawnables(models: ModelPath, world: World, sources: Sequence[str]) -> tuple[list[Found], str]:
    """All models that can be simulated, and what was not looked at, in sentences, if there is anything."""
    folders, problems = folders_of(sources)
    given = ((f"{FILE}{path.as_posix()}", path) for path in files_of(folders, SUFFIXES))
    files = chain(models.files(SUFFIXES), given)
    found = [*_props(world), *_simulable(dict(islice(files, MAX_FILES)))]
    if next(files, None) is not None:
        problems.append(f"after {MAX_FILES} files no more were looked at")
    return found, "; ".join(problems)


def _props(world: World) -> Iterator[Found]:
    for prop in world.props:
        yield _found(f"{PROP}{prop.name}", f"as the prop {prop.name} of the world", prop.model)


def _simulable(files: Mapping[str, Path]) -> Iterator[Found]:
    for uri, path in files.items():
        try:
            model = parse_model(read_input_text(path, Kind.MODEL))
        except (RequestRefused, OSError, UnicodeDecodeError):  # it could not be spawned
            continue
        yield _found(uri, path.name, model)


def _found(uri: str, what: str, model: BodyModel) -> Found:
    bounds = bounding_box(model.parts)
    assert bounds is not None, "models have parts"
    return Found(uri, f"{what}, {'fixed' if model.static else f'{model.mass:g} kg'}", bounds)
