"""Conversion of plain Python values from applications: SI base units, names of enumeration members.

| declared              | plain value                                                      |
|-----------------------|------------------------------------------------------------------|
| `bool`, `string`      | `bool`, `str`                                                    |
| `int`, `uint`         | `int`, within 64 bits                                            |
| `float`, physical     | `float` or `int`; physical values in the SI base unit            |
| enumerations          | name of the member: `"red"` or `"color!red"`                     |
| structs               | mapping of all fields                                            |
| actors                | name of the actor                                                |
| `list of T`           | list or tuple of these                                           |
| `range of T`          | mapping of `low` and `high`                                      |

Traces contain such values, so values from a trace can be passed again.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import assert_never

from seoro.lang import plan
from seoro.runtime.values.values import INTEGER_LIMITS, Actor, Range, Struct, Value


class InvalidValue(Exception):
    """A plain value does not match a type; the message names the expected and the found value."""


def given_value(
    given: object, type_: plan.ValueType, structures: plan.Structures, actors: Mapping[str, Actor]
) -> Value:
    """Convert a plain value to a value of a type.

    Args:
        given: The plain value.
        type_: The type.
        structures: Structures of all types.
        actors: Actors by name.

    Raises:
        InvalidValue: The value does not match.
    """
    match type_:
        case plan.PrimitiveType() | plan.PhysicalType():
            return _number_or_text(given, type_)
        case plan.EnumType():
            return _member(given, type_)
        case plan.ListType(element) if isinstance(given, list | tuple):
            return tuple(given_value(item, element, structures, actors) for item in given)
        case plan.RangeType(element) if isinstance(given, Mapping) and given.keys() == {"low", "high"}:
            low, high = (given_value(given[name], element, structures, actors) for name in ("low", "high"))
            assert isinstance(low, int | float) and isinstance(high, int | float), "ranges are numeric"
            return Range(low, high)
        case plan.StructType() if isinstance(given, Mapping):
            return _struct(given, type_, structures, actors)
        case plan.ActorType(name):
            actor = actors.get(given) if isinstance(given, str) else None
            if actor is None or name not in actor.types:
                known = [each for each, actor in actors.items() if name in actor.types]
                raise _invalid(given, type_, f" (actors: {', '.join(known) or 'none'})")
            return actor
        case plan.ListType() | plan.RangeType() | plan.StructType():
            raise _invalid(given, type_)
        case _:
            assert_never(type_)


def type_text(type_: plan.ValueType) -> str:
    """Describe plain values of a type."""
    match type_:
        case plan.PrimitiveType("bool"):
            return "`True` or `False`"
        case plan.PrimitiveType("string"):
            return "a string"
        case plan.PrimitiveType("int" | "uint" as name):
            return f"an integer (`{name}`)"
        case plan.PrimitiveType():
            return "a number"
        case plan.PhysicalType(name, unit):
            return f"a number in {unit} (`{name}`)"
        case plan.EnumType(name, members):
            return f"a member of `{name}`: {', '.join(member for member, _ in members)}"
        case plan.StructType(name, _, fields):
            return f"a mapping with the fields of `{name}`: {', '.join(fields)}"
        case plan.ActorType(name):
            return f"the name of an actor `{name}`"
        case plan.ListType(element):
            return f"a list with elements of: {type_text(element)}"
        case plan.RangeType():
            return "a mapping of `low` and `high`"
        case _:
            assert_never(type_)


def _invalid(given: object, type_: plan.ValueType, more: str = "") -> InvalidValue:
    return InvalidValue(f"expected {type_text(type_)}{more}, found {given!r}")


def _number_or_text(given: object, type_: plan.PrimitiveType | plan.PhysicalType) -> Value:
    is_integer = isinstance(given, int) and not isinstance(given, bool)
    match type_:
        case plan.PrimitiveType("bool") if isinstance(given, bool):
            return given
        case plan.PrimitiveType("string") if isinstance(given, str):
            return given
        case plan.PrimitiveType("int" | "uint" as name):
            low, high = INTEGER_LIMITS[name]
            if isinstance(given, int) and is_integer and low <= given <= high:
                return given
        case plan.PrimitiveType("float") | plan.PhysicalType():
            if isinstance(given, int | float) and (is_integer or isinstance(given, float)):
                if math.isfinite(given):
                    return float(given)
                raise _invalid(given, type_, " that is finite")
        case _:
            pass
    raise _invalid(given, type_)


def _member(given: object, type_: plan.EnumType) -> plan.EnumValue:
    prefix = f"{type_.name}!"
    name = given.removeprefix(prefix) if isinstance(given, str) else given
    for member, number in type_.members:
        if member == name:
            return plan.EnumValue(type_.name, member, number)
    raise _invalid(given, type_)


def _struct(
    given: Mapping[str, object], type_: plan.StructType, structures: plan.Structures, actors: Mapping[str, Actor]
) -> Struct:
    fields = structures.of(type_).fields
    if given.keys() != fields.keys():
        raise _invalid(dict(given), type_)
    made = Struct(type_)
    for name, declared in fields.items():
        made.fields[name] = given_value(given[name], declared.type, structures, actors)
    return made
