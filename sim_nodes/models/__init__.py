"""Body models from SDF, URDF and MJCF files, for the loaders of engines."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from types import MappingProxyType
from typing import Any

from seoro.bridges.wire import SpawnResult
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.models.xml_reading import parse_xml
from sim_nodes.physics import BodyModel
from sim_nodes.views import Colour

FORMATS = ("sdf", "urdf", "mjcf")
CACHED = 32  # models with the files that they name
NO_FILES: Mapping[str, bytes] = MappingProxyType({})


def parse_model(
    text: str, files: Mapping[str, bytes] = NO_FILES, *, static: bool = False, colour: Colour | None = None
) -> BodyModel:
    """Parse the text of an SDF, URDF or MJCF file.

    Args:
        text: Text of the file.
        files: Files that it names, by virtual path (`seoro.bridges.model_files`).
        static: Whether the body is static regardless of the file.
        colour: Colour of the whole body; None for the colours of the file.

    Raises:
        RequestRefused: The format is unknown, or the text is invalid or has unsupported parts.
    """
    return _parsed(text, tuple(sorted(files.items())), static=static, colour=colour)


@lru_cache(maxsize=CACHED)
def _parsed(text: str, files: tuple[tuple[str, bytes], ...], *, static: bool, colour: Colour | None) -> BodyModel:
    # Readers load meshes, and worlds without models start without them.
    from sim_nodes.models.canonical import canonical_model  # noqa: PLC0415
    from sim_nodes.models.sdf import translate_sdf  # noqa: PLC0415

    root: Any = parse_xml(text)
    match root.tag:
        case "robot":
            return canonical_model(root, dict(files), static=static, colour=colour)
        case "sdf":
            return canonical_model(translate_sdf(root, dict(files)), dict(files), static=static, colour=colour)
        case "mujoco":
            return _mjcf_model(root, dict(files), static=static, colour=colour)
        case other:
            raise RequestRefused(
                SpawnResult.UNSUPPORTED_FORMAT,
                f"unknown root element <{other}> of the model; expected <sdf>, <robot> (URDF) or <mujoco> (MJCF)",
            )


def _mjcf_model(root: Any, files: Mapping[str, bytes], *, static: bool, colour: Colour | None) -> BodyModel:
    from sim_nodes.models.canonical import canonical_model  # noqa: PLC0415
    from sim_nodes.models.mjcf import bundle_mjcf  # noqa: PLC0415

    try:
        from sim_nodes.mujoco.to_urdf import compile_mjcf, urdf_of  # noqa: PLC0415
    except ImportError as error:
        raise RequestRefused(
            SpawnResult.UNSUPPORTED_FORMAT,
            "MJCF files are read by MuJoCo, also for other engines; install it: pip install 'seoro[mujoco]'",
        ) from error
    mjcf = bundle_mjcf(root, files)
    element, meshes = urdf_of(compile_mjcf(mjcf))
    return replace(canonical_model(element, meshes, static=static, colour=colour), mjcf=mjcf)
