"""From plain values to numbers, truth values and texts that the wire has."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Final, TypeAlias

import numpy as np

from seoro.bridges.ros2.interfaces.definitions import INTEGERS, Scalar
from seoro.bridges.ros2.interfaces.mismatch import Mismatch

Convert: TypeAlias = Callable[[Any], Any]

_GREATEST_FLOAT32: Final = float(np.finfo(np.float32).max)


def scalar_converter(type_: Scalar) -> Convert:
    """What turns a value into one of a primitive type, or raises a `Mismatch`."""
    match type_.name:
        case "bool":
            return _truth
        case "string":
            return _text_converter(type_)
        case "byte":
            return _octet
        case "float32" | "float64" as name:
            return _float_converter(name)
        case name:
            return _integer_converter(name)


def _truth(value: Any) -> bool:
    if isinstance(value, bool | np.bool_):
        return bool(value)
    raise Mismatch("true or false", value)


def _octet(value: Any) -> int:
    if isinstance(value, bytes) and len(value) == 1:  # as rclpy has it
        return value[0]
    converted: int = _integer_converter("byte")(value)
    return converted


def _integer_converter(name: str) -> Convert:
    low, high = INTEGERS[name]

    def integer(value: Any) -> int:
        if type(value) is not int:
            if not isinstance(value, int | np.integer) or isinstance(value, bool):
                raise Mismatch(f"a whole number ({name})", value)
            value = int(value)
        if not low <= value <= high:
            raise Mismatch(f"a whole number from {low} to {high} ({name})", value)
        return int(value)

    return integer


def _float_converter(name: str) -> Convert:
    greatest = _GREATEST_FLOAT32 if name == "float32" else math.inf

    def number(value: Any) -> float:
        if type(value) is not float:
            if not isinstance(value, float | int | np.floating | np.integer) or isinstance(value, bool):
                raise Mismatch(f"a number ({name})", value)
            try:
                value = float(value)
            except OverflowError:
                raise Mismatch(f"a number that {name} has", value) from None
        if greatest < abs(value) < math.inf:
            raise Mismatch(f"a number up to {greatest} ({name})", value)
        return float(value)

    return number


def _text_converter(type_: Scalar) -> Convert:
    bound = type_.bound

    def text(value: Any) -> str:
        if not isinstance(value, str):
            raise Mismatch(
                "a text", value, "write numbers in quotes where a text is meant" * isinstance(value, int | float)
            )
        if "\0" in value:
            raise Mismatch("a text without the character NUL, which would end it", value)
        try:
            length = len(value) if value.isascii() else len(value.encode())
        except UnicodeEncodeError:
            raise Mismatch("a text in Unicode", value) from None
        if 0 < bound < length:
            raise Mismatch(f"a text of at most {bound} bytes", value)
        return value

    return text
