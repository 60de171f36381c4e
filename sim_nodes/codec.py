"""Values as bytes and back, without pickle: msgpack, and extensions for what it has no word for.

What goes in is plain data, arrays, and frozen data of this package and of the wire: dataclasses, pydantic models,
named tuples, enumerations. What comes out is equal to the bit. Bytes can name classes of those kinds only, and
making one computes nothing.
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

HOMES = ("sim_nodes.", "seoro.bridges.wire")  # modules whose frozen classes may be named
MAX_ELEMENTS = 10_000_000  # of a value, with those that are packed within it
MAX_DEPTH = 100  # of what is packed at once
KINDS = "biufc"  # of numbers in arrays: bool, int, unsigned, float, complex


class CodecError(Exception):
    """A value that has no bytes, or bytes that are no value."""


class _Kind(IntEnum):
    """What an extension holds."""

    TUPLE = 1
    SET = 2
    FROZENSET = 3
    DEQUE = 4
    ARRAY = 5
    RECORD = 6  # a class by name, and its fields
    MEMBER = 7  # of an enumeration
    BIG = 8  # an integer that 64 bits do not hold
    SCALAR = 9  # a number of numpy's own types


def pack(value: object) -> bytes:
    """The bytes of a value.

    Raises:
        CodecError: There is something in it that is not data.
    """
    try:
        packed: bytes = msgpack.packb(value, default=_extension, strict_types=True)
    except (TypeError, ValueError, OverflowError) as error:
        raise CodecError(str(error)) from error
    return packed


def unpack(data: bytes) -> Any:
    """The value of some bytes, with arrays of its own.

    Raises:
        CodecError: They are none that `pack` makes.
    """
    return _unpack(data, [MAX_ELEMENTS])


def _unpack(data: bytes, left: list[int]) -> Any:
    """As `unpack`; `left` has the elements that all that is packed within one another may still have."""
    try:
        left[0] -= check_limits(data, Limits(len(data), left[0], MAX_DEPTH))
        return msgpack.unpackb(data, ext_hook=partial(_value, left), strict_map_key=False)
    except CodecError:
        raise
    except (ValueError, TypeError, KeyError, msgpack.UnpackException, RecursionError) as error:
        raise CodecError(f"these bytes are no value: {error}") from error


def copied(value: Any) -> Any:
    """What `unpack(pack(value))` is, without the bytes: a value that changes of the other do not reach.

    Raises:
        CodecError: There is something in it that is not data.
    """
    kind: Any = type(value)
    return value if kind in _PLAIN else _copier(kind)(value)


_PLAIN = frozenset({type(None), bool, int, float, str, bytes})


@cache
def _copier(kind: type) -> Callable[[Any], Any]:
    """How values of a class are copied: looked up once, since a simulation that goes ahead is saved often.

    Raises:
        CodecError: They are no data.
    """
    if issubclass(kind, int | float | str | bytes | Enum | BaseModel):  # models are frozen, as all that they hold
        return _same
    if issubclass(kind, np.ndarray | np.generic | set | frozenset):  # in sets are values that do not change
        return kind.copy
    if issubclass(kind, dict):
        return lambda value: {key: copied(each) for key, each in value.items()}
    if issubclass(kind, list):
        return lambda value: [copied(each) for each in value]
    if issubclass(kind, deque):
        return lambda value: deque(map(copied, value), value.maxlen)
    if issubclass(kind, tuple):
        return _copied_named if hasattr(kind, "_fields") else lambda value: tuple(map(copied, value))
    if is_dataclass(kind):
        return partial(_copied_record, tuple(each.name for each in fields(kind)))
    raise CodecError(f"{_called(kind)} is no data that can be saved")


def _same(value: Any) -> Any:
    return value


def _copied_named(value: Any) -> Any:
    return type(value)(*map(copied, value))


def _copied_record(names: tuple[str, ...], record: Any) -> Any:
    copies = {}
    is_same = True
    for name in names:
        value = getattr(record, name)
        copies[name] = copy = copied(value)
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
            return _Kind.RECORD, [_name(type(value)), dict(value)]
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
            raise CodecError(f"{_called(type(value))} is no data that can be saved")


def _value(left: list[int], code: int, data: bytes) -> Any:
    content = _unpack(data, left)
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
            raise CodecError(f"there is no value of kind {code}")


def _array(dtype: np.dtype[Any], shape: list[int], numbers: bytes) -> Any:
    if dtype.kind not in KINDS:
        raise CodecError(f"an array of {dtype} holds no numbers")
    return np.frombuffer(numbers, dtype).reshape(shape).copy()  # a copy, since bytes cannot be changed


def _called(kind: type) -> str:
    return f"{kind.__module__}.{kind.__qualname__}"


def _name(kind: type) -> str:
    if not _may_be_named(kind):
        raise CodecError(f"{_called(kind)} is no frozen data of {' or '.join(HOMES)}")
    return f"{kind.__module__}:{kind.__qualname__}"


def _class(name: str) -> Any:
    """The class of a name, if its module is loaded: nothing is imported for what bytes say."""
    module, _, path = name.partition(":")
    found: Any = sys.modules.get(module) if module.startswith(HOMES) else None
    for part in path.split("."):
        found = getattr(found, part, None)
    if not (isinstance(found, type) and _may_be_named(found)):
        raise CodecError(f"there is no frozen data {name!r}")
    return found


def _may_be_named(kind: type) -> bool:
    if not f"{kind.__module__}.".startswith(HOMES):
        return False
    if issubclass(kind, BaseModel):
        return bool(kind.model_config.get("frozen"))
    if is_dataclass(kind):
        made: Any = kind
        return bool(made.__dataclass_params__.frozen)
    return issubclass(kind, Enum) or (issubclass(kind, tuple) and hasattr(kind, "_fields"))
