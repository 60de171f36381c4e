"""Definitions that a robot tells: `type_description_interfaces/msg/TypeDescription` as packages of interfaces.

What nodes tell has no constants, and its defaults are left out. The numbers of the types of fields are those that
type hashes are made of, so that whoever compares the hash has compared everything.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from seoro.bridges.ros2.interfaces.definitions import (
    Array,
    Element,
    Field,
    FieldType,
    Named,
    Scalar,
    Sequence,
    Structure,
    wire_fields,
)
from seoro.bridges.ros2.interfaces.derived import SUFFIXES
from seoro.bridges.ros2.interfaces.errors import InvalidDefinition
from seoro.bridges.ros2.interfaces.hashes import ARRAY, BOUNDED_SEQUENCE, BOUNDED_TEXT, IDS, NESTED, SEQUENCE
from seoro.bridges.ros2.interfaces.names import PARTS, Name, parse_name
from seoro.bridges.ros2.interfaces.packages import Package, Source, ToldPackage
from seoro.bridges.ros2.interfaces.text import lines

MOST: Final = 1000  # structures of one description
_PRIMITIVES: Final = {number: name for name, number in IDS.items() if name != "char"}
_TEXTS: Final = {IDS[name] + BOUNDED_TEXT: name for name in ("string", "wstring")}
_KINDS: Final = (0, ARRAY, BOUNDED_SEQUENCE, SEQUENCE)


def told_packages(description: Any, packages: Mapping[str, Package], origin: str) -> dict[str, Package]:
    """Packages in which what is described, messages and services, takes the place of what has the same name.

    Args:
        description: A `type_description_interfaces/msg/TypeDescription`, decoded.
        packages: The packages that there are, by name.
        origin: Who has told it, for messages.

    Raises:
        InvalidDefinition: It is none of messages and services, or has what cannot be.
    """
    told = (description.type_description, *description.referenced_type_descriptions)
    if len(told) > MOST:
        raise InvalidDefinition(f"{origin}: more than {MOST} structures are described")
    parts: dict[Name, str] = {}
    for each in told:
        name = parse_name(each.type_name)
        if name is None or name.suffix not in SUFFIXES.get(name.kind, ()) or name.kind == "action":
            raise InvalidDefinition(f"{origin}: `{each.type_name}` is no message, and no service")
        if name.suffix in PARTS[name.kind]:  # the rest follows from these
            parts[name] = "".join(f"{line}\n" for line in lines(_structure(each, origin)))
    sources: dict[str, dict[str, Source]] = {}
    for name in parts:
        texts = [parts.get(name._replace(suffix=suffix)) for suffix in PARTS[name.kind]]
        if None in texts:
            raise InvalidDefinition(f"{origin}: `{name.interface}` is described in part only")
        text = "---\n".join(text for text in texts if text is not None)
        sources.setdefault(name.package, {})[name.interface] = Source(text, origin)
    return {package: ToldPackage(found, packages.get(package), origin) for package, found in sources.items()}


def _structure(told: Any, origin: str) -> Structure:
    empty = Structure(told.type_name, ())
    fields = tuple(_field(field, origin) for field in told.fields)
    return empty if fields == wire_fields(empty) else Structure(told.type_name, fields)


def _field(told: Any, origin: str) -> Field:
    number = int(told.type.type_id)
    kind = max(each for each in _KINDS if each <= number)
    element = _element(told.type, number - kind)
    if element is None:
        raise InvalidDefinition(f"{origin}: `{told.name}` is of a type that messages do not have ({number})")
    return Field(told.name, _type(element, kind, int(told.type.capacity)))


def _type(element: Element, kind: int, capacity: int) -> FieldType:
    if kind == ARRAY:
        return Array(element, capacity)
    return element if kind == 0 else Sequence(element, capacity if kind == BOUNDED_SEQUENCE else 0)


def _element(told: Any, number: int) -> Element | None:
    if number == NESTED:
        return Named(told.nested_type_name)
    if number in _TEXTS:
        return Scalar(_TEXTS[number], int(told.string_capacity))
    return Scalar(_PRIMITIVES[number]) if number in _PRIMITIVES else None
