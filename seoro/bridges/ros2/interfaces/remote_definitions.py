"""Definitions fetched from robots: `type_description_interfaces/msg/TypeDescription` as packages of interfaces.

Descriptions have no constants, and their defaults are ignored. The numbers of field types are those in type
hashes, so a comparison of hashes compares all fields.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from seoro.bridges.ros2.interfaces import definitions
from seoro.bridges.ros2.interfaces.derived import SUFFIXES
from seoro.bridges.ros2.interfaces.errors import InvalidDefinition
from seoro.bridges.ros2.interfaces.hashes import ARRAY, BOUNDED_SEQUENCE, BOUNDED_TEXT, IDS, NESTED, SEQUENCE
from seoro.bridges.ros2.interfaces.names import PARTS, Name, parse_name
from seoro.bridges.ros2.interfaces.packages import Package, RemotePackage, Source
from seoro.bridges.ros2.interfaces.text import lines

MAX_STRUCTURES: Final = 1000  # in a description
_PRIMITIVES: Final = {number: name for name, number in IDS.items() if name != "char"}
_TEXTS: Final = {IDS[name] + BOUNDED_TEXT: name for name in ("string", "wstring")}
_KINDS: Final = (0, ARRAY, BOUNDED_SEQUENCE, SEQUENCE)


def remote_packages(description: Any, packages: Mapping[str, Package], origin: str) -> dict[str, Package]:
    """Return the packages of the described messages and services, which replace those of the same name.

    Args:
        description: A decoded `type_description_interfaces/msg/TypeDescription`.
        packages: Known packages by name, with the other definitions.
        origin: Node that has sent the description, in error messages.

    Raises:
        InvalidDefinition: The description is invalid, or has other structures than messages and services.
    """
    structures = (description.type_description, *description.referenced_type_descriptions)
    if len(structures) > MAX_STRUCTURES:
        raise InvalidDefinition(f"{origin}: more than {MAX_STRUCTURES} structures")
    parts: dict[Name, str] = {}
    for each in structures:
        name = parse_name(each.type_name)
        if name is None or name.suffix not in SUFFIXES.get(name.kind, ()) or name.kind == "action":
            raise InvalidDefinition(f"{origin}: `{each.type_name}` is not a message or service")
        if name.suffix in PARTS[name.kind]:  # the other structures are derived
            parts[name] = "".join(f"{line}\n" for line in lines(_structure(each, origin)))
    sources: dict[str, dict[str, Source]] = {}
    for name in parts:
        texts = [parts.get(name._replace(suffix=suffix)) for suffix in PARTS[name.kind]]
        if None in texts:
            raise InvalidDefinition(f"{origin}: incomplete description of `{name.interface}`")
        text = "---\n".join(text for text in texts if text is not None)
        sources.setdefault(name.package, {})[name.interface] = Source(text, origin)
    return {package: RemotePackage(found, packages.get(package), origin) for package, found in sources.items()}


def _structure(description: Any, origin: str) -> definitions.Structure:
    fields = tuple(_field(field, origin) for field in description.fields)
    return definitions.Structure(description.type_name, () if fields == definitions.FILLER else fields)


def _field(description: Any, origin: str) -> definitions.Field:
    number = int(description.type.type_id)
    kind = max(each for each in _KINDS if each <= number)
    element = _element(description.type, number - kind)
    if element is None:
        raise InvalidDefinition(f"{origin}: unsupported type {number} of `{description.name}`")
    return definitions.Field(description.name, _type(element, kind, int(description.type.capacity)))


def _type(element: definitions.Element, kind: int, capacity: int) -> definitions.FieldType:
    if kind == ARRAY:
        return definitions.Array(element, capacity)
    return element if kind == 0 else definitions.Sequence(element, capacity if kind == BOUNDED_SEQUENCE else 0)


def _element(description: Any, number: int) -> definitions.Element | None:
    if number == NESTED:
        return definitions.Named(description.nested_type_name)
    if number in _TEXTS:
        return definitions.Scalar(_TEXTS[number], int(description.string_capacity))
    return definitions.Scalar(_PRIMITIVES[number]) if number in _PRIMITIVES else None
