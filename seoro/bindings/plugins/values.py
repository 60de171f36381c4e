"""Values of the language as classes for scenario_execution expect them."""

from __future__ import annotations

from typing import Any

from seoro.lang.plan import EnumValue, PhysicalType, PrimitiveType, ValueType
from seoro.runtime.functions.fitting import scalar
from seoro.runtime.values.values import Actor, Range, Struct, Value, Variable


def passed(value: Value) -> Any:
    """Convert a value: structs and actors are dictionaries, enumerations pairs of name and number.

    Physical values are in SI base units.
    """
    match value:
        case EnumValue():
            return value.member, value.number
        case Struct():
            return {name: passed(part) for name, part in value.fields.items()}
        case Actor():
            return {**{name: passed(part) for name, part in value.fields.items()}, "name": value.name}
        case Variable():
            return passed(value.value)
        case Range():
            return value.low, value.high
        case tuple():
            return [passed(item) for item in value]
        case _:
            return value


def returned(value: Any, declared: ValueType, path: str) -> Value:
    """Convert a new value of a variable.

    Args:
        value: The value, in the SI base unit.
        declared: Type of the variable.
        path: Name of the variable in messages.

    Raises:
        TypeError: The types differ, or the variable is not a boolean, a number or a string.
    """
    made = scalar(value, declared) if isinstance(declared, PrimitiveType | PhysicalType) else None
    if made is None:
        raise TypeError(f"cannot set `{path}` to {value!r}: expected {declared}")
    return made
