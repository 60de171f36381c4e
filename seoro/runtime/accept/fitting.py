"""Whether values are of types, and the same as others."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import assert_never

from seoro.lang.plan import (
    ActorType,
    EnumType,
    EnumValue,
    ListType,
    PhysicalType,
    PrimitiveType,
    RangeType,
    StructType,
    ValueType,
)
from seoro.runtime.jsonl import to_json
from seoro.runtime.values import INTEGER_LIMITS, Actor, Range, Struct, Value, Variable, plain


def fits(value: Value, type_: ValueType) -> bool:
    """Whether a value is one of a type."""
    match type_:
        case PrimitiveType("bool"):
            return isinstance(value, bool)
        case PrimitiveType("string"):
            return isinstance(value, str)
        case PrimitiveType("float") | PhysicalType():
            return isinstance(value, int | float) and not isinstance(value, bool)
        case PrimitiveType(name):
            low, high = INTEGER_LIMITS[name]
            return isinstance(value, int) and not isinstance(value, bool) and low <= value <= high
        case EnumType(name, members):
            is_enum = isinstance(value, EnumValue) and value.type_name == name
            return is_enum and (value.member, value.number) in members  # type: ignore[union-attr] # it is one
        case StructType(name) | ActorType(name):
            return isinstance(value, Struct | Actor) and name in value.types
        case ListType(element):
            return isinstance(value, tuple) and all(fits(item, element) for item in value)
        case RangeType(element):
            return isinstance(value, Range) and fits(value.low, element) and fits(value.high, element)
        case _:
            assert_never(type_)


def same(told: Value, expected: Value) -> bool:
    """Whether a value of the trace is one that was expected; a struct that was made for that has equal fields."""
    match told, expected:
        case (Struct(), Struct()):
            return told is expected or (
                told.type.name == expected.type.name
                and told.fields.keys() == expected.fields.keys()
                and all(same(told.fields[name], expected.fields[name]) for name in expected.fields)
            )
        case (Variable(), Variable()):
            return told.holder is expected.holder and told.name == expected.name
        case (tuple(), tuple()):
            return len(told) == len(expected) and all(map(same, told, expected))
        case (float(), float()) if told != told:  # noqa: PLR0124 - not a number
            return expected != expected  # noqa: PLR0124
        case _:
            return told == expected


def is_plain_form(told: object, value: Value | Mapping[str, Value]) -> bool:
    """Whether JSON is the form of a value, or of values by name, that is for people."""
    match value:
        case Mapping():
            are_there = isinstance(told, dict) and told.keys() == value.keys()
            return are_there and all(is_plain_form(told[name], part) for name, part in value.items())  # type: ignore[index] # it is a dict
        case Struct():
            return is_plain_form(told, dict(value.fields.items()))
        case tuple():
            return (
                isinstance(told, list | tuple) and len(told) == len(value) and all(map(is_plain_form, told, value))
            )
        case Range(low, high):
            return is_plain_form(told, {"low": low, "high": high})
        case float() if not math.isfinite(value):
            return to_json(told).strip('"') == to_json(value).strip('"')
        case bool():
            return told is value
        case int() | float():
            return isinstance(told, int | float) and not isinstance(told, bool) and told == value
        case _:
            return told == plain(value)
