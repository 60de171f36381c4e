"""Type hashes of ROS 2, which are part of every key of rmw_zenoh.

The hashes follow REP-2011 and `rosidl_generator_type_description`: SHA-256 of the JSON of a structure and all
nested structures. They depend on the names of types and fields, but not on defaults and constants.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from typing import Any, Final, assert_never

from seoro.bridges.ros2.interfaces import definitions

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
