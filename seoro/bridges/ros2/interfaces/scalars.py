"""Conversion of plain values to numbers, booleans and strings of messages."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final, TypeAlias

import numpy as np

from seoro.bridges.ros2.interfaces.definitions import INTEGERS, Scalar
from seoro.bridges.ros2.interfaces.mismatch import mismatch_of

Convert: TypeAlias = Callable[[Any], Any]

_GREATEST_FLOAT32: Final = (2 - 2**-23) * 2.0**127


def scalar_converter(type_: Scalar) -> Convert:
    """Return a converter to a primitive type; it raises `Mismatch` for an invalid value."""
    match type_.name:
        case "bool":
            return _truth
        case "string":
            return _text_converter(type_)
        case "byte":
            return _octet
        case "float32":
            return _float32
        case "float64":
            return _float64
        case name:
            return _integer_converter(name)


def _truth(value: Any) -> bool:
    if isinstance(value, bool | np.bool_):
        return bool(value)
    raise mismatch_of("true or false", value)


def _octet(value: Any) -> int:
    if isinstance(value, bytes) and len(value) == 1:  # as in rclpy
        return value[0]
    converted: int = _integer_converter("byte")(value)
    return converted


def _integer_converter(name: str) -> Convert:
    low, high = INTEGERS[name]

    def integer(value: Any) -> int:
        if type(value) is not int:
            if not isinstance(value, int | np.integer) or isinstance(value, bool):
                raise mismatch_of(f"a whole number ({name})", value, "write it without quotes" * _is_number(value))
            value = int(value)
        if low <= value <= high:
            return value  # type: ignore[no-any-return]
        raise mismatch_of(f"a whole number from {low} to {high} ({name})", value)

    return integer


def _float64(value: Any) -> float:
    if type(value) is float:
        return value
    if not isinstance(value, float | int | np.floating | np.integer) or isinstance(value, bool):
        raise mismatch_of("a number", value, "write it without quotes" * _is_number(value))
    try:
        return float(value)
    except OverflowError:
        raise mismatch_of("a number within the range of float64", value) from None


def _is_number(value: object) -> bool:
    """Return whether a value is a string with a number."""
    try:
        return isinstance(value, str) and math.isfinite(float(value))
    except ValueError:
        return False


def _float32(value: Any) -> float:
    number = _float64(value)
    if _GREATEST_FLOAT32 < abs(number) < math.inf:
        raise mismatch_of(f"a number up to {_GREATEST_FLOAT32} (float32)", value)
    return number


def _text_converter(type_: Scalar) -> Convert:
    bound = type_.bound

    def text(value: Any) -> str:
        if not isinstance(value, str):
            raise mismatch_of(
                "a string", value, "write a number in quotes to make it a string" * isinstance(value, int | float)
            )
        if "\0" in value:
            raise mismatch_of("a string without the character NUL", value)
        try:
            length = len(value) if value.isascii() else len(value.encode())
        except UnicodeEncodeError:
            raise mismatch_of("a valid Unicode string", value) from None
        if 0 < bound < length:
            raise mismatch_of(f"a string of at most {bound} bytes", value)
        return value

    return text
