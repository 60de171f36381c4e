"""Body models from SDF, URDF and MJCF files, for the loaders of engines."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from seoro.bridges.wire.refusal import name_list
from sim_nodes.models.cache import ModelCache, key_of
from sim_nodes.models.scenes import SceneBody, read_bodies
from sim_nodes.models.settings import FROM_FILE, ModelSettings
from sim_nodes.models.xml_reading import invalid
from sim_nodes.physics import BodyModel

FORMATS = ("sdf", "urdf", "mjcf")
CACHED = 256 << 20  # [bytes] of all models that were read last
NO_FILES: Mapping[str, bytes] = MappingProxyType({})


def parse_model(
    text: str, files: Mapping[str, bytes] = NO_FILES, settings: ModelSettings = FROM_FILE
) -> BodyModel:
    """Parse the text of an SDF, URDF or MJCF file with one body.

    Args:
        text: Text of the file.
        files: Files that it names, by virtual path (`seoro.bridges.model_files`).
        settings: Settings of the reader.

    Raises:
        RequestRefused: The format is unknown, or the text is invalid or has several bodies or unsupported parts.
    """
    bodies = parse_bodies(text, files, settings)
    if len(bodies) > 1:
        names = name_list(body.name for body in bodies)
        raise invalid(f"found {len(bodies)} bodies in the file that move apart: {names}; expected one")
    return bodies[0].model


def parse_bodies(
    text: str, files: Mapping[str, bytes] = NO_FILES, settings: ModelSettings = FROM_FILE
) -> tuple[SceneBody, ...]:
    """Parse the text of an SDF, URDF or MJCF file, perhaps with several bodies that move freely.

    Bodies without a free joint are one static body with their joints, the first of the file.

    Args:
        text: Text of the file.
        files: Files that it names, by virtual path (`seoro.bridges.model_files`).
        settings: Settings of the reader.

    Returns:
        The bodies, at least one.

    Raises:
        RequestRefused: The format is unknown, or the text is invalid or has unsupported parts.
    """
    key = key_of(text, files, settings)
    bodies = _cache.get(key, lambda: read_bodies(text, files, settings, apart=False))
    if not bodies:
        raise invalid("found no shapes besides floors in the model; expected one or more")
    return bodies


_cache = ModelCache(CACHED)
