"""Common parts of the readers of models: untrusted XML, bounded numbers, nested frames."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from defusedxml import DefusedXmlException, ElementTree

from seoro.bridges.wire import SpawnResult
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.geometry import Frame, Vector, compose_frames
from sim_nodes.physics import IDENTITY, Part

MAX_TEXT = 4_000_000  # [characters]
MAX_DEPTH = 50  # of nested bodies and links
SIZES = (0.01, 20.0)  # [m] edge, radius or length
PLACES = (-1000.0, 1000.0)  # [m], [rad] or degrees
MASSES = (1e-3, 1e4)  # [kg]
FRICTIONS = (0.0, 10.0)
INERTIA = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
MOST_INERTIA = 1e6  # [kg m^2]
INERTIAS = (-MOST_INERTIA, MOST_INERTIA)
ROUNDED = 1e-6  # relative rounding error of moments of inertia in a file
ORIGIN: Frame = ((0.0, 0.0, 0.0), IDENTITY)


def parse_xml(text: str) -> Any:
    """Parse an XML text; returns its root element.

    Raises:
        RequestRefused: The text is too long, not well-formed, or refers to other resources.
    """
    text = text.strip()  # some files begin with an empty line, which XML forbids
    if len(text) > MAX_TEXT:
        raise invalid(f"the model has more than {MAX_TEXT} characters")
    try:
        return ElementTree.fromstring(text)
    except (ElementTree.ParseError, DefusedXmlException, ValueError) as error:
        raise invalid(f"invalid XML of the model: {error}") from error


def invalid(message: str) -> RequestRefused:
    """Return the refusal of an invalid model."""
    return RequestRefused(SpawnResult.RESOURCE_PARSE_ERROR, message)


def label(element: Any) -> str:
    """Return the text for an element in messages."""
    name = element.get("name")
    return f"<{element.tag} name={name!r}>" if name else f"<{element.tag}>"


def numbers(text: str | None, what: str, count: int, bounds: tuple[float, float]) -> list[float]:
    """Parse `count` numbers within bounds; `what` names them in messages."""
    shown = (text or "").strip()
    try:
        values = [float(word) for word in shown.split()]
    except ValueError as error:
        raise invalid(f"invalid {what}: {shown!r}; expected {_numbers(count)}") from error
    if len(values) != count:
        raise invalid(f"invalid {what}: {shown!r}; expected {_numbers(count)}")
    low, high = bounds
    if not all(low <= value <= high for value in values):
        raise invalid(f"invalid {what}: {shown!r}; expected {low:g} to {high:g}")
    return values


def _numbers(count: int) -> str:
    return "a number" if count == 1 else f"{count} numbers"


def vector(text: str | None, what: str, bounds: tuple[float, float] = PLACES) -> Vector:
    """Parse three numbers within bounds."""
    x, y, z = numbers(text, what, 3, bounds)
    return x, y, z


def moved(part: Part, frame: Frame) -> Part:
    """Return a part that is given in a frame, in the parent of that frame."""
    position, orientation = compose_frames(frame, (part.position, part.orientation))
    return replace(part, position=position, orientation=orientation)
