"""Models of bodies: SDF, URDF and MJCF files as what every engine can simulate."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from seoro.bridges.wire import SpawnResult
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.models.mjcf import read_mjcf
from sim_nodes.models.reading import parse_xml
from sim_nodes.models.sdf import read_sdf
from sim_nodes.models.urdf import read_urdf
from sim_nodes.physics import BodyModel

# By the root elements of their files.
_READERS: Mapping[str, Callable[..., BodyModel]] = {"sdf": read_sdf, "robot": read_urdf, "mujoco": read_mjcf}
FORMATS = ("sdf", "urdf", "mjcf")


def parse_model(text: str, *, static: bool = False) -> BodyModel:
    """The body that the text of an SDF, URDF or MJCF file describes.

    Args:
        text: The text.
        static: Whether the body is to stand fixed, whatever the file says.

    Raises:
        RequestRefused: The text is none of these, or has something in it that is not supported.
    """
    root: Any = parse_xml(text)
    if root.tag not in _READERS:
        raise RequestRefused(
            SpawnResult.UNSUPPORTED_FORMAT,
            f"the model's root element is <{root.tag}>: it has to be <sdf>, <robot> (URDF) or <mujoco> (MJCF)",
        )
    return _READERS[root.tag](root, static=static)
