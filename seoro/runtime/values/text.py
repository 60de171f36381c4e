"""Text of values as written in the language: `2.5mps`, `[1..3]`, `color!red`, `point(x: 1.0m, y: 0.0m)`."""

from __future__ import annotations

import json
import math

from seoro.lang.plan import EnumValue, ListType, PhysicalType, PrimitiveType, RangeType, Structures, ValueType
from seoro.runtime.values.values import Actor, Range, Struct, Value, Variable

_FLOAT = PrimitiveType("float")


def value_text(value: Value, type_: ValueType | None, structures: Structures, digits: int | None = None) -> str:
    """Format a value as an expression of the language.

    Args:
        value: The value.
        type_: Its static type, for the units of numbers; None if unknown.
        structures: Structures of all types, for fields of structs.
        digits: Significant digits of floats; None for as many as are needed to distinguish them.
    """
    match value:
        case bool():
            return "true" if value else "false"
        case int() if not isinstance(type_, PhysicalType) and type_ != _FLOAT:
            return str(value)
        case int() | float():
            return _float_text(float(value), digits) + _unit(value, type_)
        case str():
            return json.dumps(value, ensure_ascii=False)
        case EnumValue(type_name, member):
            return f"{type_name}!{member}"
        case Actor(name=name):
            return name
        case Variable():
            return value.path
        case Range(low, high):
            element = type_.element if isinstance(type_, RangeType) else None
            low_text, high_text = (value_text(bound, element, structures, digits) for bound in (low, high))
            return f"[{low_text}..{high_text}]"
        case tuple():
            element = type_.element if isinstance(type_, ListType) else None
            return f"[{', '.join(value_text(item, element, structures, digits) for item in value)}]"
        case Struct():
            return _struct_text(value, structures, digits)


def message_text(value: Value, type_: ValueType | None, structures: Structures) -> str:
    """Format a value for messages: strings as they are."""
    return str(value) if isinstance(value, str) else value_text(value, type_, structures)


def _struct_text(value: Struct, structures: Structures, digits: int | None) -> str:
    structure = structures.find(value.type)
    types = {name: declared.type for name, declared in structure.fields.items()} if structure is not None else {}
    fields = (
        f"{name}: {value_text(part, types.get(name), structures, digits)}" for name, part in value.fields.items()
    )
    return f"{value.type.name}({', '.join(fields)})"


def _float_text(value: float, digits: int | None) -> str:
    """Format a float, which needs a decimal point in the language."""
    if not math.isfinite(value):
        return str(value)
    text = repr(value) if digits is None else f"{value:.{digits}g}"
    mantissa, mark, exponent = text.partition("e")
    return mantissa + ("" if "." in mantissa else ".0") + mark + exponent


def _unit(value: float, type_: ValueType | None) -> str:
    if not isinstance(type_, PhysicalType) or not math.isfinite(value):
        return ""
    return type_.literal or (f" {type_.unit}" if type_.unit else "")
