"""Body models from SDF, URDF and MJCF files, as far as every engine can simulate them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from seoro.bridges.wire import SpawnResult
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.models.mjcf import read_mjcf
from sim_nodes.models.sdf import read_sdf
from sim_nodes.models.urdf import read_urdf
from sim_nodes.models.xml_reading import parse_xml
from sim_nodes.physics import BodyModel

# Readers by the root element of a file.
_READERS: Mapping[str, Callable[..., BodyModel]] = {"sdf": read_sdf, "robot": read_urdf, "mujoco": read_mjcf}
FORMATS = ("sdf", "urdf", "mjcf")


def parse_model(text: str, *, static: bool = False) -> BodyModel:
    """Parse the text of an SDF, URDF or MJCF file.

    Args:
        text: Text of the file.
        static: Whether the body is static regardless of the file.

    Raises:
        RequestRefused: The format is unknown, or the text is invalid or has unsupported parts.
    """
    root: Any = parse_xml(text)
    if root.tag not in _READERS:
        raise RequestRefused(
            SpawnResult.UNSUPPORTED_FORMAT,
            f"unknown root element <{root.tag}> of the model; expected <sdf>, <robot> (URDF) or <mujoco> (MJCF)",
        )
    return _READERS[root.tag](root, static=static)
