"""Encodes values as bytes without pickle: msgpack with extensions.

Accepted are plain data, arrays, and frozen data of this package and of the wire: dataclasses, pydantic models,
named tuples, enumerations. Decoded values are bit-identical. Bytes can name classes of those kinds only, and
constructing one computes nothing.
"""

from __future__ import annotations

import sys
from collections import deque
from collections.abc import Callable
from dataclasses import fields, is_dataclass
from enum import Enum, IntEnum
from functools import cache, partial
from typing import Any

import msgpack
import numpy as np
from pydantic import BaseModel

from seoro.bridges.wire.limits import Limits, check_limits

PACKAGES = ("sim_nodes.", "seoro.bridges.wire", "seoro.robotics.")  # modules whose frozen classes may be named
MAX_ELEMENTS = 10_000_000  # of a value, including nested extensions
MAX_DEPTH = 100  # of nested extensions
KINDS = "biufc"  # dtype kinds of arrays: bool, int, unsigned, float, complex


class CodecError(Exception):
    """A value cannot be encoded, or bytes cannot be decoded."""


class _Kind(IntEnum):
    """Type code of an extension."""

    TUPLE = 1
    SET = 2
    FROZENSET = 3
    DEQUE = 4
    ARRAY = 5
    RECORD = 6  # a class by name, and its fields
    MEMBER = 7  # of an enumeration
    BIG = 8  # an integer beyond 64 bits
    SCALAR = 9  # a numpy scalar


def pack(value: object) -> bytes:
    """Encode a value.

    Raises:
        CodecError: It contains something that is not data.
    """
    try:
        packed: bytes = msgpack.packb(value, default=_extension, strict_types=True)
    except (TypeError, ValueError, OverflowError) as error:
        raise CodecError(str(error)) from error
    return packed


def unpack(data: bytes) -> Any:
    """Decode a value; its arrays own their memory.

    Raises:
        CodecError: The bytes are invalid.
    """
    return _unpack(data, [MAX_ELEMENTS])


def _unpack(data: bytes, remaining: list[int]) -> Any:
    """Decode with a limit: `remaining` holds the number of elements that may still follow."""
    try:
        remaining[0] -= check_limits(data, Limits(len(data), remaining[0], MAX_DEPTH))
        return msgpack.unpackb(data, ext_hook=partial(_value, remaining), strict_map_key=False)
    except CodecError:
        raise
    except (ValueError, TypeError, KeyError, msgpack.UnpackException, RecursionError) as error:
        raise CodecError(f"invalid bytes: {error}") from error


def deep_copy(value: Any) -> Any:
    """Return a deep copy of `value`, equal to `unpack(pack(value))`.

    Raises:
        CodecError: It contains something that is not data.
    """
    kind: Any = type(value)
    return value if kind in _PLAIN else _copier(kind)(value)


_PLAIN = frozenset({type(None), bool, int, float, str, bytes})


@cache
def _copier(kind: type) -> Callable[[Any], Any]:
    """Return the copy function of a class. Cached, because lookahead copies states often.

    Raises:
        CodecError: The class is not data.
    """
    if issubclass(kind, int | float | str | bytes | Enum | BaseModel):  # models are frozen
        return lambda value: value
    if issubclass(kind, np.ndarray | np.generic | set | frozenset):  # elements of sets are immutable
        return kind.copy
    if issubclass(kind, dict):
        return lambda value: {key: deep_copy(each) for key, each in value.items()}
    if issubclass(kind, list):
        return lambda value: [deep_copy(each) for each in value]
    if issubclass(kind, deque):
        return lambda value: deque(map(deep_copy, value), value.maxlen)
    if issubclass(kind, tuple):
        if hasattr(kind, "_fields"):
            return lambda value: kind(*map(deep_copy, value))
        return lambda value: tuple(map(deep_copy, value))
    if is_dataclass(kind):
        return partial(_copied_record, tuple(each.name for each in fields(kind)))
    raise CodecError(f"unsupported type {_full_name(kind)}; expected data")


def _copied_record(names: tuple[str, ...], record: Any) -> Any:
    copies = {}
    is_same = True
    for name in names:
        value = getattr(record, name)
        copies[name] = copy = deep_copy(value)
        is_same = is_same and copy is value
    return record if is_same else type(record)(**copies)


def _extension(value: object) -> msgpack.ExtType:
    kind, content = _content(value)
    return msgpack.ExtType(kind, pack(content))


def _content(value: object) -> tuple[_Kind, object]:
    match value:
        case Enum():
            return _Kind.MEMBER, [_name(type(value)), value.name]
        case BaseModel():
            return _Kind.RECORD, [
                _name(type(value)),
                {name: getattr(value, name) for name in type(value).model_fields},
            ]
        case tuple() if hasattr(value, "_fields"):
            return _Kind.RECORD, [_name(type(value)), dict(zip(value._fields, value, strict=True))]
        case tuple():
            return _Kind.TUPLE, list(value)
        case frozenset():
            return _Kind.FROZENSET, sorted(value)
        case set():
            return _Kind.SET, sorted(value)
        case deque():
            return _Kind.DEQUE, [value.maxlen, list(value)]
        case np.ndarray() if value.dtype.kind in KINDS:
            return _Kind.ARRAY, [value.dtype.str, list(value.shape), value.tobytes()]
        case np.generic() if value.dtype.kind in KINDS:
            return _Kind.SCALAR, [value.dtype.str, value.tobytes()]
        case int():
            return _Kind.BIG, str(value)
        case _ if is_dataclass(value):
            return _Kind.RECORD, [
                _name(type(value)),
                {each.name: getattr(value, each.name) for each in fields(value)},
            ]
        case _:
            raise CodecError(f"unsupported type {_full_name(type(value))}; expected data")


def _value(remaining: list[int], code: int, data: bytes) -> Any:
    content = _unpack(data, remaining)
    match code:
        case _Kind.TUPLE:
            return tuple(content)
        case _Kind.SET:
            return set(content)
        case _Kind.FROZENSET:
            return frozenset(content)
        case _Kind.DEQUE:
            maxlen, values = content
            return deque(values, maxlen)
        case _Kind.ARRAY:
            dtype, shape, numbers = content
            return _array(np.dtype(dtype), shape, numbers)
        case _Kind.RECORD:
            name, values = content
            return _class(name)(**values)
        case _Kind.MEMBER:
            name, member = content
            return _class(name)[member]
        case _Kind.BIG:
            return int(content)
        case _Kind.SCALAR:
            dtype, number = content
            return _array(np.dtype(dtype), [], number)[()]
        case _:
            raise CodecError(f"unknown extension {code}")


def _array(dtype: np.dtype[Any], shape: list[int], numbers: bytes) -> Any:
    if dtype.kind not in KINDS:
        raise CodecError(f"unsupported array of {dtype}; expected numbers")
    return np.frombuffer(numbers, dtype).reshape(shape).copy()  # a copy, because bytes are immutable


def _full_name(kind: type) -> str:
    return f"{kind.__module__}.{kind.__qualname__}"


def _name(kind: type) -> str:
    if not _is_encodable(kind):
        raise CodecError(f"unsupported type {_full_name(kind)}; expected frozen data of {' or '.join(PACKAGES)}")
    return f"{kind.__module__}:{kind.__qualname__}"


def _class(name: str) -> Any:
    """Look up a class in loaded modules; decoding imports nothing."""
    module, _, path = name.partition(":")
    found: Any = sys.modules.get(module) if module.startswith(PACKAGES) else None
    for part in path.split("."):
        found = getattr(found, part, None)
    if not (isinstance(found, type) and _is_encodable(found)):
        raise CodecError(f"unknown frozen data {name!r}")
    return found


def _is_encodable(kind: type) -> bool:
    if not f"{kind.__module__}.".startswith(PACKAGES):
        return False
    if issubclass(kind, BaseModel):
        return bool(kind.model_config.get("frozen"))
    if is_dataclass(kind):
        made: Any = kind
        return bool(made.__dataclass_params__.frozen)
    return issubclass(kind, Enum) or (issubclass(kind, tuple) and hasattr(kind, "_fields"))
