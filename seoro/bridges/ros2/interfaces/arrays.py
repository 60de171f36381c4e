"""Conversion of lists and numpy arrays to members of messages."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from seoro.bridges.ros2.interfaces.definitions import Array, Scalar, Sequence
from seoro.bridges.ros2.interfaces.messages import Message
from seoro.bridges.ros2.interfaces.mismatch import Mismatch, mismatch_of
from seoro.bridges.ros2.interfaces.scalars import Convert, scalar_converter

_OCTETS: Final = ("byte", "char", "uint8")


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
