"""Type hashes of ROS 2, which are part of every key of rmw_zenoh, and descriptions of types.

The hashes follow REP-2011 and `rosidl_generator_type_description`: SHA-256 of the JSON of a structure and all
nested structures. They depend on the names of types and fields, but not on defaults and constants.

Robots send descriptions, `type_description_interfaces/msg/TypeDescription`, which become packages of interfaces.
They have no constants, and their defaults are ignored. The numbers of field types are those in type hashes, so a
comparison of hashes compares all fields.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from typing import Any, Final, assert_never

from seoro.bridges.ros2.interfaces import definitions
from seoro.bridges.ros2.interfaces.errors import InvalidDefinition
from seoro.bridges.ros2.interfaces.names import PARTS, Name, parse_name
from seoro.bridges.ros2.interfaces.packages import Package, Source, remote_package
from seoro.bridges.ros2.interfaces.text import definition

NESTED: Final = 1
IDS: Final = {  # type_description_interfaces/msg/FieldType; `char` is uint8 in IDL
    "int8": 2,
    "uint8": 3,
    "char": 3,
    "int16": 4,
    "uint16": 5,
    "int32": 6,
    "uint32": 7,
    "int64": 8,
    "uint64": 9,
    "float32": 10,
    "float64": 11,
    "bool": 15,
    "byte": 16,
    "string": 17,
    "wstring": 18,
}
BOUNDED_TEXT: Final = 4  # a bounded string is 21, a bounded wstring 22
ARRAY, BOUNDED_SEQUENCE, SEQUENCE = 48, 96, 144
MAX_STRUCTURES: Final = 1000  # in a description
_PRIMITIVES: Final = {number: name for name, number in IDS.items() if name != "char"}
_TEXTS: Final = {IDS[name] + BOUNDED_TEXT: name for name in ("string", "wstring")}
_KINDS: Final = (0, ARRAY, BOUNDED_SEQUENCE, SEQUENCE)


def type_hash(name: str, lookup: Callable[[str], definitions.Structure]) -> str:
    """Return the hash of a structure, such as `RIHS01_6398fe76...`.

    Args:
        name: Full name of the structure.
        lookup: Returns a structure by its full name.
    """
    description = json.dumps(described(name, lookup))
    return f"RIHS01_{hashlib.sha256(description.encode()).hexdigest()}"


def described(name: str, lookup: Callable[[str], definitions.Structure]) -> dict[str, Any]:
    """Return the description of a structure, as members of a `type_description_interfaces/msg/TypeDescription`.

    Args:
        name: Full name of the structure.
        lookup: Returns a structure by its full name.
    """
    found: dict[str, dict[str, Any]] = {}
    missing = [name]
    while missing:
        structure = lookup(missing.pop())
        if structure.name in found:
            continue
        fields = definitions.wire_fields(structure)
        found[structure.name] = {"type_name": structure.name, "fields": [_field(field) for field in fields]}
        elements = [definitions.element_of(field.type) for field in fields]
        missing.extend(element.name for element in elements if isinstance(element, definitions.Named))
    top = found.pop(name)
    return {
        "type_description": top,
        "referenced_type_descriptions": [found[referenced] for referenced in sorted(found)],
    }


def _field(field: definitions.Field) -> dict[str, Any]:
    match field.type:
        case definitions.Array(_, length):
            offset, capacity = ARRAY, length
        case definitions.Sequence(_, bound):
            offset, capacity = (BOUNDED_SEQUENCE if bound else SEQUENCE), bound
        case definitions.Scalar() | definitions.Named():
            offset, capacity = 0, 0
        case _:
            assert_never(field.type)
    match definitions.element_of(field.type):
        case definitions.Named(nested):
            number, length, name = NESTED, 0, nested
        case definitions.Scalar(primitive, bound):
            number, length, name = IDS[primitive] + (BOUNDED_TEXT if bound else 0), bound, ""
    return {
        "name": field.name,
        "type": {
            "type_id": offset + number,
            "capacity": capacity,
            "string_capacity": length,
            "nested_type_name": name,
        },
    }


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
        if name is None or name.suffix not in definitions.SUFFIXES.get(name.kind, ()) or name.kind == "action":
            raise InvalidDefinition(f"{origin}: `{each.type_name}` is not a message or service")
        if name.suffix in PARTS[name.kind]:  # the other structures are derived
            parts[name] = definition(_structure(each, origin))
    sources: dict[str, dict[str, Source]] = {}
    for name in parts:
        texts = [parts.get(name._replace(suffix=suffix)) for suffix in PARTS[name.kind]]
        if None in texts:
            raise InvalidDefinition(f"{origin}: incomplete description of `{name.interface}`")
        text = "---\n".join(text for text in texts if text is not None)
        sources.setdefault(name.package, {})[name.interface] = Source(text, origin)
    return {package: remote_package(found, packages.get(package), origin) for package, found in sources.items()}


def _structure(description: Any, origin: str) -> definitions.Structure:
    fields = tuple(_described_field(field, origin) for field in description.fields)
    return definitions.Structure(description.type_name, () if fields == definitions.FILLER else fields)


def _described_field(description: Any, origin: str) -> definitions.Field:
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
