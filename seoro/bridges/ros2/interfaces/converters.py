"""Conversion of plain values, lists and numpy arrays to members of messages."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, Final, TypeAlias

import numpy as np

from seoro.bridges.ros2.interfaces.definitions import INTEGERS, Array, Scalar, Sequence
from seoro.bridges.ros2.interfaces.messages import Message

Convert: TypeAlias = Callable[[Any], Any]

_GREATEST_FLOAT32: Final = (2 - 2**-23) * 2.0**127
_OCTETS: Final = ("byte", "char", "uint8")


class Mismatch(Exception):
    """A value does not fit its type; the path grows while the error passes the enclosing structures."""

    def __init__(self, problem: str, help: str = "") -> None:  # noqa: A002
        super().__init__(problem)
        self.path = ""
        self.help = help

    def within(self, member: str) -> None:
        """Prepend a member, such as `position` or `[2]`, to the path."""
        self.path = member + ("" if not self.path or self.path.startswith("[") else ".") + self.path


def mismatch_of(expected: str, given: object, help: str = "") -> Mismatch:  # noqa: A002
    """Return the mismatch of an expected and a given value."""
    return Mismatch(f"expected {expected}, got {_description(given)}", help)


def _description(value: object) -> str:
    """Return a short description of a value."""
    match value:
        case None:
            return "nothing"
        case bool():
            return str(value).lower()
        case Message():
            return f"a {value.__msgtype__}"
        case np.ndarray():
            return f"an array of {value.dtype} with the shape {value.shape}"
        case Mapping():
            return f"a mapping with {len(value)} entries"
        case list() | tuple():
            return f"a list of {len(value)}"
        case bytes() | bytearray() | memoryview():
            return f"{len(value)} bytes"
        case int() | float():
            return _cut(repr(value)) if not isinstance(value, int) or value.bit_length() < 256 else "a huge number"
        case str():
            return f"the string {_cut(repr(value))}"
        case _:
            return f"a {type(value).__name__}"


def _cut(text: str) -> str:
    return text if len(text) <= 60 else f"{text[:57]}..."


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


def list_converter(type_: Array | Sequence, convert: Convert) -> Convert:
    """Return a converter of lists of strings or structures; `convert` converts an element."""

    def converted(value: Any) -> list[Any]:
        if not _is_list(value):
            raise mismatch_of(f"a list ({type_})", value)
        _check_length(type_, len(value))
        return _all(value, convert)

    return converted


def array_converter(type_: Array | Sequence, element: Scalar) -> Convert:
    """Return a converter of lists, bytes and numpy arrays to numpy arrays of numbers or booleans."""
    dtype = np.dtype(np.uint8 if element.name in _OCTETS else element.name)
    convert = scalar_converter(element)

    def array(value: Any) -> np.ndarray[Any, Any]:
        if isinstance(value, np.ndarray):
            made = _converted_array(type_, value, dtype)
        elif isinstance(value, bytes | bytearray) and element.name in _OCTETS:
            made = np.frombuffer(value, dtype)
        elif not _is_list(value):
            raise mismatch_of(f"a list ({type_})", value)
        else:
            _check_length(type_, len(value))
            return np.array(_all(value, convert), dtype)
        _check_length(type_, len(made))
        return made

    return array


def _is_list(value: Any) -> bool:
    return isinstance(value, list | tuple) and not isinstance(value, Message)  # messages are tuples too


def _converted_array(
    type_: Array | Sequence, value: np.ndarray[Any, Any], dtype: np.dtype[Any]
) -> np.ndarray[Any, Any]:
    """Convert a numpy array to a type; return the same array if possible."""
    if value.ndim != 1:
        raise mismatch_of(f"one dimension ({type_})", value, "`array.ravel()` has all elements, row by row")
    if value.dtype != dtype:
        kinds = {"f": "fiu", "i": "iu", "u": "iu", "b": "b"}[dtype.kind]
        if value.dtype.kind not in kinds and value.size:
            raise mismatch_of(f"an array of {dtype}", value)
        if dtype.kind in "iu" and value.size:
            limits = np.iinfo(dtype)
            if int(value.min()) < limits.min or int(value.max()) > limits.max:
                raise mismatch_of(f"numbers from {limits.min} to {limits.max} ({type_})", value)
        with np.errstate(over="ignore"):
            converted = value.astype(dtype)
        if dtype.kind == "f" and not np.array_equal(np.isinf(converted), np.isinf(value)):
            raise mismatch_of(f"numbers within the range of {dtype}", value)
        value = converted
    return np.ascontiguousarray(value)


def _all(values: list[Any] | tuple[Any, ...], convert: Convert) -> list[Any]:
    made: list[Any] = []
    try:
        for value in values:
            made.append(convert(value))
    except Mismatch as mismatch:
        mismatch.within(f"[{len(made)}]")
        raise
    return made


def _check_length(type_: Array | Sequence, length: int) -> None:
    if isinstance(type_, Array) and length != type_.length:
        raise Mismatch(f"expected {type_.length} elements ({type_}), got {length}")
    if isinstance(type_, Sequence) and 0 < type_.bound < length:
        raise Mismatch(f"expected at most {type_.bound} elements ({type_}), got {length}")
