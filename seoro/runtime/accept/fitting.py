"""Types and equality of values in traces."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import assert_never

from seoro.lang import plan
from seoro.runtime.trace.jsonl import to_json
from seoro.runtime.values.values import INTEGER_LIMITS, Actor, Range, Struct, Value, Variable, plain


def fits(value: Value, type_: plan.ValueType) -> bool:
    """Whether a value has a type."""
    match type_:
        case plan.PrimitiveType("bool"):
            return isinstance(value, bool)
        case plan.PrimitiveType("string"):
            return isinstance(value, str)
        case plan.PrimitiveType("float") | plan.PhysicalType():
            return isinstance(value, int | float) and not isinstance(value, bool)
        case plan.PrimitiveType(name):
            low, high = INTEGER_LIMITS[name]
            return isinstance(value, int) and not isinstance(value, bool) and low <= value <= high
        case plan.EnumType(name, members):
            is_enum = isinstance(value, plan.EnumValue) and value.type_name == name
            return is_enum and (value.member, value.number) in members  # type: ignore[union-attr] # an enumeration
        case plan.StructType(name) | plan.ActorType(name):
            return isinstance(value, Struct | Actor) and name in value.types
        case plan.ListType(element):
            return isinstance(value, tuple) and all(fits(item, element) for item in value)
        case plan.RangeType(element):
            return isinstance(value, Range) and fits(value.low, element) and fits(value.high, element)
        case _:
            assert_never(type_)


def same(recorded: Value, expected: Value) -> bool:
    """Whether a value of the trace equals an expected one; structs constructed for it are compared by fields."""
    match recorded, expected:
        case (Struct(), Struct()):
            return recorded is expected or (
                recorded.type.name == expected.type.name
                and recorded.fields.keys() == expected.fields.keys()
                and all(same(recorded.fields[name], expected.fields[name]) for name in expected.fields)
            )
        case (Variable(), Variable()):
            return recorded.holder is expected.holder and recorded.name == expected.name
        case (tuple(), tuple()):
            return len(recorded) == len(expected) and all(map(same, recorded, expected))
        case (float(), float()) if recorded != recorded:  # noqa: PLR0124 - not a number
            return expected != expected  # noqa: PLR0124
        case _:
            return recorded == expected


def is_plain_form(recorded: object, value: Value | Mapping[str, Value]) -> bool:
    """Whether JSON is the plain form of a value, or of values by name."""
    match value:
        case Mapping():
            are_there = isinstance(recorded, dict) and recorded.keys() == value.keys()
            return are_there and all(is_plain_form(recorded[name], part) for name, part in value.items())  # type: ignore[index] # it is a dict
        case Struct():
            return is_plain_form(recorded, dict(value.fields.items()))
        case tuple():
            return (
                isinstance(recorded, list | tuple)
                and len(recorded) == len(value)
                and all(map(is_plain_form, recorded, value))
            )
        case Range(low, high):
            return is_plain_form(recorded, {"low": low, "high": high})
        case float() if not math.isfinite(value):
            return to_json(recorded).strip('"') == to_json(value).strip('"')
        case bool():
            return recorded is value
        case int() | float():
            return isinstance(recorded, int | float) and not isinstance(recorded, bool) and recorded == value
        case _:
            return recorded == plain(value)
