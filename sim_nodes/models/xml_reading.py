"""Common parts of the readers of models: untrusted XML, bounded numbers, nested frames."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from defusedxml import DefusedXmlException, ElementTree

from seoro.bridges.wire import SpawnResult
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.extents import volume
from sim_nodes.geometry import Quaternion, Vector, multiply, rotation_matrix
from sim_nodes.geometry import vector as array_vector
from sim_nodes.physics import IDENTITY, BodyModel, Box, Cylinder, Part, Shape, Sphere
from sim_nodes.views import Colour

SHAPES = "box, cylinder or sphere"
MAX_TEXT = 1_000_000  # [characters]
MAX_PARTS = 64
MAX_DEPTH = 50  # of nested bodies and links
SIZES = (0.01, 20.0)  # [m] edge, radius or length
PLACES = (-1000.0, 1000.0)  # [m], [rad] or degrees
MASSES = (1e-3, 1e4)  # [kg]
FRICTIONS = (0.0, 10.0)
INERTIA = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
MOST_INERTIA = 1e6  # [kg m^2]
INERTIAS = (-MOST_INERTIA, MOST_INERTIA)
ROUNDED = 1e-6  # relative rounding error of moments of inertia in a file
ORIGIN: tuple[Vector, Quaternion] = ((0.0, 0.0, 0.0), IDENTITY)
CENTRE_TOLERANCE = 0.01  # [m] between the given centre of mass and that of uniformly filled shapes

Frame = tuple[Vector, Quaternion]


def parse_xml(text: str) -> Any:
    """Parse an XML text; returns its root element.

    Raises:
        RequestRefused: The text is too long, not well-formed, or refers to other resources.
    """
    if len(text) > MAX_TEXT:
        raise invalid(f"the model has more than {MAX_TEXT} characters")
    try:
        return ElementTree.fromstring(text)
    except (ElementTree.ParseError, DefusedXmlException, ValueError) as error:
        raise invalid(f"invalid XML of the model: {error}") from error


def invalid(message: str) -> RequestRefused:
    """Return the refusal of an invalid model."""
    return RequestRefused(SpawnResult.RESOURCE_PARSE_ERROR, message)


def no_meshes() -> RequestRefused:
    """Return the refusal of a mesh."""
    return RequestRefused(SpawnResult.UNSUPPORTED_ASSETS, f"unsupported mesh; expected {SHAPES}")


def label(element: Any) -> str:
    """Return the text for an element in messages."""
    name = element.get("name")
    return f"<{element.tag} name={name!r}>" if name else f"<{element.tag}>"


def check_inertia(what: str, values: Sequence[float]) -> None:
    """Refuse an inertia tensor that no body can have, by its elements xx, yy, zz, xy, xz and yz [kg m^2].

    Principal moments are positive, and none is larger than the sum of the other two. `what` names its element in
    messages.
    """
    xx, yy, zz, xy, xz, yz = values
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    if not np.all(np.isfinite(tensor)):
        raise invalid(f"invalid inertia of {what}; expected finite numbers")
    moments = np.sort(np.linalg.eigvalsh(tensor))
    shown = ", ".join(f"{moment:.6g}" for moment in moments)
    if moments[0] <= 0.0 or moments[2] > MOST_INERTIA:
        raise invalid(
            f"the inertia of {what} has the principal moments {shown} kg m^2; expected more than 0, and at most "
            f"{MOST_INERTIA:g}"
        )
    if moments[0] + moments[1] < moments[2] * (1.0 - ROUNDED):
        raise invalid(
            f"the inertia of {what} has the principal moments {shown} kg m^2; expected that none is larger than "
            "the sum of the other two, which holds for all bodies"
        )


def check_children(element: Any, known: frozenset[str]) -> None:
    """Refuse unknown child elements."""
    unknown = sorted({str(child.tag) for child in element} - known)
    if unknown:
        allowed = ", ".join(f"<{name}>" for name in sorted(known)) or "nothing"
        raise invalid(f"{label(element)} contains the unsupported <{unknown[0]}>; expected {allowed}")


def check_attributes(element: Any, known: Iterable[str]) -> None:
    """Refuse unknown attributes."""
    unknown = sorted(set(element.keys()) - set(known))
    if unknown:
        raise invalid(
            f"{label(element)} has the unsupported attribute {unknown[0]!r}; expected {', '.join(sorted(known))}"
        )


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


def read_colour(text: str | None, what: str) -> Colour:
    """Parse red, green, blue and optional opacity from 0 to 1; opacity is ignored."""
    count = 3 if len((text or "").split()) == 3 else 4
    red, green, blue, *_ = numbers(text, what, count, (0.0, 1.0))
    return red, green, blue, 1.0


def read_shape(what: str, geometry: Any, read: Callable[[Any, str, int], list[float]], known: str) -> Shape:
    """Read the shape of a <geometry>, which may be missing.

    Args:
        what: Text for its parent in messages.
        geometry: The element, or None.
        read: Reads numbers of a shape, by their name and count.
        known: Text for the supported shapes in messages.

    Raises:
        RequestRefused: The shape is missing or unsupported.
    """
    children = [] if geometry is None else list(geometry)
    if len(children) != 1:
        raise invalid(f"invalid {what}; expected a <geometry> with one shape")
    [shape] = children
    match shape.tag:
        case "box":
            x, y, z = read(shape, "size", 3)
            return Box((x, y, z))
        case "cylinder":
            return Cylinder(read(shape, "radius", 1)[0], read(shape, "length", 1)[0])
        case "sphere":
            return Sphere(read(shape, "radius", 1)[0])
        case "mesh":
            raise no_meshes()
        case other:
            raise invalid(f"unsupported <{other}> in <geometry>; expected {known}")


def compose_frames(outer: Frame, inner: Frame) -> Frame:
    """Compose frames: `inner` is given in `outer`; returns it in the parent of `outer`."""
    return array_vector(rotation_matrix(outer[1]) @ inner[0] + outer[0]), multiply(outer[1], inner[1])


def moved(part: Part, frame: Frame) -> Part:
    """Return a part that is given in a frame, in the parent of that frame."""
    position, orientation = compose_frames(frame, (part.position, part.orientation))
    return replace(part, position=position, orientation=orientation)


def with_masses(parts: Iterable[Part], mass: float) -> tuple[Part, ...]:
    """Return parts that share a mass [kg] by volume."""
    found = tuple(parts)
    whole = sum(volume(part.shape) for part in found)
    return tuple(replace(part, mass=mass * volume(part.shape) / whole) for part in found)


def check_centre(what: str, given: Vector, parts: Iterable[Part]) -> None:
    """Refuse a centre of mass that differs from that of uniformly filled shapes."""
    found = tuple(parts)
    centre = np.average([part.position for part in found], axis=0, weights=[volume(part.shape) for part in found])
    if float(np.abs(centre - given).max()) > CENTRE_TOLERANCE:
        x, y, z = centre.tolist()
        raise invalid(
            f"{what} has its centre of mass at ({given[0]:g}, {given[1]:g}, {given[2]:g}), but shapes are filled "
            f"uniformly, which gives ({x:.3f}, {y:.3f}, {z:.3f}): move the shapes, or add one with a mass"
        )


def body_of(parts: tuple[Part, ...], *, static: bool, colour: Colour | None, friction: float = 1.0) -> BodyModel:
    """Return the body of parts with masses.

    Raises:
        RequestRefused: The number of parts or their mass is out of bounds.
    """
    if not 1 <= len(parts) <= MAX_PARTS:
        raise invalid(f"found {len(parts)} collision shapes in the model; expected 1 to {MAX_PARTS}")
    if static:
        return BodyModel(parts, friction=friction, static=True, colour=colour)
    mass = sum(part.mass or 0.0 for part in parts)
    if not MASSES[0] <= mass <= MASSES[1]:
        raise invalid(f"the model has a mass of {mass:g} kg; expected {MASSES[0]:g} to {MASSES[1]:g} kg")
    return BodyModel(parts, mass=mass, friction=friction, colour=colour)
