"""Numeric types of values: implicit conversion (7.4.2.3.1), `.is()` and `.as()` (7.4.2.5, 7.4.2.6)."""

from __future__ import annotations

import math
from typing import assert_never

from seoro.lang.arithmetic import Number, wrap
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
from seoro.lang.source import Span
from seoro.runtime.values.environment import EvaluationError
from seoro.runtime.values.values import INTEGER_LIMITS, Actor, Range, Struct, Value


def to_number(value: Value, number: Number) -> Value:
    """Convert a number to a numeric type, with 64-bit integers; of a list or a range, each element."""
    match value:
        case tuple():
            return tuple(to_number(item, number) for item in value)
        case Range(low, high):
            return range_between(wrap(low, number), wrap(high, number))
        case _:
            assert isinstance(value, int | float)
            return wrap(value, number)


def range_between(first: float, second: float) -> Range:
    """Return the range between two bounds in any order (7.4.2.8.1)."""
    return Range(second, first) if second < first else Range(first, second)


def is_of(value: Value, type_: ValueType) -> bool:
    """Whether a value is of a structured type; of a list, whether all elements are."""
    match type_:
        case StructType(name) | ActorType(name):
            return isinstance(value, Struct | Actor) and name in value.types
        case ListType(element):
            return isinstance(value, tuple) and all(is_of(item, element) for item in value)
        case PrimitiveType() | PhysicalType() | EnumType() | RangeType():
            raise AssertionError("decided when it was checked")
        case _:
            assert_never(type_)


def cast(value: Value, type_: ValueType, span: Span) -> Value:
    """Convert a value to a type.

    Raises:
        EvaluationError: It cannot be converted.
    """
    match type_:
        case PrimitiveType("float") | PhysicalType():
            return to_number(value, Number.FLOAT)
        case PrimitiveType(name):
            return _to_integer(value, name, span)
        case EnumType(name, members):
            found = next((member for member, number in members if number == value), None)
            if found is None:
                raise EvaluationError(f"`{name}` has no member with the number {value}", span)
            return EnumValue(name, found, dict(members)[found])
        case ListType(element):
            assert isinstance(value, tuple)
            return tuple(cast(item, element, span) for item in value)
        case RangeType(element):
            bounds = (value.low, value.high) if isinstance(value, Range) else (value, value)
            low, high = (cast(bound, element, span) for bound in bounds)
            assert isinstance(low, int | float) and isinstance(high, int | float)
            return Range(low, high)
        case StructType(name) | ActorType(name):
            if not is_of(value, type_):
                assert isinstance(value, Struct | Actor)
                raise EvaluationError(f"expected `{name}`, found `{value.type.name}`", span)
            return value
        case _:
            assert_never(type_)


def _to_integer(value: Value, name: str, span: Span) -> int:
    """Convert a number, or the number of an enumeration member, to an integer; fractions are truncated."""
    number = value.number if isinstance(value, EnumValue) else value
    assert isinstance(number, int | float)
    low, high = INTEGER_LIMITS[name]
    if isinstance(number, float) and not math.isfinite(number):
        raise EvaluationError(f"cannot convert {number} to `{name}`", span)
    if not low <= int(number) <= high:
        raise EvaluationError(f"{number} does not fit into `{name}`", span)
    return int(number)


def wrapped(value: float, type_: ValueType) -> float:
    """Wrap an integer to the 64 bits of its type; floats stay."""
    if not isinstance(value, int):
        return value
    return wrap(value, Number.UINT if type_ == PrimitiveType("uint") else Number.INT)
