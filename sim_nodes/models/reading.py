"""What readers of models have in common: XML that is not trusted, numbers within limits, frames within frames."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from defusedxml import DefusedXmlException, ElementTree

from seoro.bridges.wire import SpawnResult
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.colours import Colour
from sim_nodes.geometry import Array, Quaternion, Vector, multiply, rotation_matrix
from sim_nodes.inertia import volume
from sim_nodes.physics import IDENTITY, BodyModel, Part

MAX_TEXT = 1_000_000  # [characters]
MAX_PARTS = 64
MAX_DEPTH = 50  # of bodies and links within each other
SIZES = (0.01, 20.0)  # [m] of an edge, radius or length
PLACES = (-1000.0, 1000.0)  # [m], [rad] or degrees
MASSES = (1e-3, 1e4)  # [kg]
FRICTIONS = (0.0, 10.0)
MOST_INERTIA = 1e6  # [kg m^2]
INERTIAS = (-MOST_INERTIA, MOST_INERTIA)
ROUNDED = 1e-6  # part of a moment of inertia that rounding in a file explains
ORIGIN: tuple[Vector, Quaternion] = ((0.0, 0.0, 0.0), IDENTITY)
CENTRE_TOLERANCE = 0.01  # [m] between the centre of mass that a file says and that of evenly filled shapes

Frame = tuple[Vector, Quaternion]


def parse_xml(text: str) -> Any:
    """The root element of a text.

    Raises:
        RequestRefused: It is too long, no well-formed XML, or refers to something outside of itself.
    """
    if len(text) > MAX_TEXT:
        raise wrong(f"the model is longer than {MAX_TEXT} characters")
    try:
        return ElementTree.fromstring(text)
    except (ElementTree.ParseError, DefusedXmlException, ValueError) as error:
        raise wrong(f"the model is no well-formed XML: {error}") from error


def wrong(message: str) -> RequestRefused:
    """The refusal of a model that says what cannot be."""
    return RequestRefused(SpawnResult.RESOURCE_PARSE_ERROR, message)


def no_meshes(known: str) -> RequestRefused:
    """The refusal of a mesh."""
    return RequestRefused(SpawnResult.UNSUPPORTED_ASSETS, f"meshes are not supported: use {known}")


def named(element: Any) -> str:
    """How messages call an element."""
    name = element.get("name")
    return f"<{element.tag} name={name!r}>" if name else f"<{element.tag}>"


def check_inertia(what: str, tensor: Array) -> None:
    """Refuse a tensor of inertia that no body has, with `what` it is of; shape (3, 3) [kg m^2].

    Its principal moments are positive, and none is larger than the sum of the other two.
    """
    if not np.all(np.isfinite(tensor)):
        raise wrong(f"the inertia of {what} has a value that is no finite number")
    moments = np.sort(np.linalg.eigvalsh(tensor))
    shown = ", ".join(f"{moment:.6g}" for moment in moments)
    if moments[0] <= 0.0 or moments[2] > MOST_INERTIA:
        raise wrong(
            f"the inertia of {what} has the principal moments {shown} kg m^2; expected more than 0, and at most "
            f"{MOST_INERTIA:g}"
        )
    if moments[0] + moments[1] < moments[2] * (1.0 - ROUNDED):
        raise wrong(
            f"the inertia of {what} has the principal moments {shown} kg m^2; expected that none is larger than "
            "the sum of the other two, which holds for all bodies"
        )


def symmetric(values: Sequence[float]) -> Array:
    """The tensor with the elements xx, yy, zz, xy, xz and yz, shape (3, 3)."""
    xx, yy, zz, xy, xz, yz = values
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def check_children(element: Any, known: frozenset[str]) -> None:
    """Refuse children of other kinds."""
    unknown = sorted({str(child.tag) for child in element} - known)
    if unknown:
        allowed = ", ".join(f"<{name}>" for name in sorted(known)) or "nothing"
        raise wrong(f"{named(element)} contains <{unknown[0]}>, which is not supported: it may contain {allowed}")


def check_attributes(element: Any, known: Iterable[str]) -> None:
    """Refuse attributes of other names."""
    unknown = sorted(set(element.keys()) - set(known))
    if unknown:
        raise wrong(
            f"{named(element)} has the attribute {unknown[0]!r}, which is not supported: "
            f"it may have {', '.join(sorted(known))}"
        )


def numbers(text: str | None, what: str, count: int, bounds: tuple[float, float]) -> list[float]:
    """So many numbers within bounds; `what` names them in messages."""
    shown = (text or "").strip()
    try:
        values = [float(word) for word in shown.split()]
    except ValueError as error:
        raise wrong(f"{what} is {shown!r}: it has to be {_numbers(count)}") from error
    if len(values) != count:
        raise wrong(f"{what} is {shown!r}: it has to be {_numbers(count)}")
    low, high = bounds
    if not all(low <= value <= high for value in values):
        raise wrong(f"{what} is {shown!r}: values are supported from {low:g} to {high:g}")
    return values


def _numbers(count: int) -> str:
    return "a number" if count == 1 else f"{count} numbers"


def vector(text: str | None, what: str, bounds: tuple[float, float] = PLACES) -> Vector:
    """Three numbers within bounds."""
    x, y, z = numbers(text, what, 3, bounds)
    return x, y, z


def read_colour(text: str | None, what: str) -> Colour:
    """Red, green, blue from 0 to 1, and, if it is there, opacity, which is not used."""
    count = 3 if len((text or "").split()) == 3 else 4
    red, green, blue, *_ = numbers(text, what, count, (0.0, 1.0))
    return red, green, blue, 1.0


def inside(outer: Frame, inner: Frame) -> Frame:
    """The frame `inner`, given in the frame `outer`, in the frame that `outer` is given in."""
    x, y, z = (rotation_matrix(outer[1]) @ inner[0] + outer[0]).tolist()
    return (x, y, z), multiply(outer[1], inner[1])


def weighed(parts: Iterable[Part], mass: float) -> tuple[Part, ...]:
    """Parts that share a mass [kg] by their volume."""
    found = tuple(parts)
    whole = sum(volume(part.shape) for part in found)
    return tuple(replace(part, mass=mass * volume(part.shape) / whole) for part in found)


def check_centre(what: str, said: Vector, parts: Iterable[Part]) -> None:
    """Refuse a centre of mass that evenly filled shapes do not have."""
    found = tuple(parts)
    is_ = np.average([part.position for part in found], axis=0, weights=[volume(part.shape) for part in found])
    if float(np.abs(is_ - said).max()) > CENTRE_TOLERANCE:
        x, y, z = is_.tolist()
        raise wrong(
            f"{what} has its centre of mass at ({said[0]:g}, {said[1]:g}, {said[2]:g}), but shapes are filled "
            f"evenly here, which puts it at ({x:.3f}, {y:.3f}, {z:.3f}): move the shapes, or add one that weighs"
        )


def body_of(parts: tuple[Part, ...], *, static: bool, colour: Colour | None, friction: float = 1.0) -> BodyModel:
    """The body of parts that have masses.

    Raises:
        RequestRefused: There are none, or too many, or they weigh too little or too much.
    """
    if not 1 <= len(parts) <= MAX_PARTS:
        raise wrong(f"the model has {len(parts)} shapes to collide with: it has to have 1 to {MAX_PARTS}")
    if static:
        return BodyModel(parts, friction=friction, static=True, colour=colour)
    mass = sum(part.mass or 0.0 for part in parts)
    if not MASSES[0] <= mass <= MASSES[1]:
        raise wrong(f"the model weighs {mass:g} kg: {MASSES[0]:g} to {MASSES[1]:g} kg are supported")
    return BodyModel(parts, mass=mass, friction=friction, colour=colour)
