"""Specifications of MuJoCo: their compilation, and names for bodies and joints without one."""

from __future__ import annotations

from typing import Any

import mujoco

from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.models import xml_reading as xml
from sim_nodes.physics import Mjcf

WORLD = 0  # body


def compile_mjcf(model: Mjcf) -> Any:
    """Compile an MJCF model; returns MuJoCo's model.

    Raises:
        RequestRefused: The model is invalid.
    """
    try:
        spec = mujoco.MjSpec.from_string(model.text, assets=dict(model.assets))
    except (ValueError, TypeError) as error:
        raise _refused(error) from error
    return compile_spec(spec)


def compile_spec(spec: Any) -> Any:
    """Compile a specification; returns MuJoCo's model.

    Raises:
        RequestRefused: The specification is invalid.
    """
    try:
        return spec.compile()
    except (ValueError, TypeError) as error:
        raise _refused(error) from error


def _refused(error: Exception) -> RequestRefused:
    return xml.invalid(f"MuJoCo refuses the model: {' '.join(str(error).split())}")


def body_name(model: Any, body: int) -> str:
    """Return the name of a body, or the one that it gets."""
    return str(model.body(body).name) or f"body_{body}"


def joint_name(model: Any, joint: int) -> str:
    """Return the name of a joint, or the one that it gets."""
    return str(model.joint(joint).name) or f"joint_{joint}"
