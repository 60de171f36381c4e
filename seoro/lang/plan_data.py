"""Plans as JSON text: a table of nodes that refer to earlier nodes by number.

A node is a list: the number of its class, then its fields. A field is null, a boolean, a finite float, a string,
or an integer, which is the number of an earlier node. So a node that is used twice stays one node, cycles are
impossible, and neither direction recurses. Spans refer to source files by number; files are not part of the data.

Decoding builds containers and the classes of `_CLASSES`, and calls nothing else. It checks the number of fields,
but not their types.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from enum import Enum
from math import inf, isfinite, nan
from typing import Any, Final, TypeAlias, cast

from seoro.lang import plan
from seoro.lang.arithmetic import Number
from seoro.lang.frozen import Frozen
from seoro.lang.source import SourceFile, Span

_INT, _FLOAT, _TUPLE, _FROZENSET, _DICT, _SPAN, _STRUCTURES, _METHODS, _FIRST_CLASS = range(9)
_CONTAINERS: Final[Mapping[type, int]] = {
    tuple: _TUPLE,
    frozenset: _FROZENSET,
    dict: _DICT,
    plan.Structures: _STRUCTURES,
    plan.Methods: _METHODS,
}
_MODULES: Final = (plan.__name__, Number.__module__)
_DEFINED: Final = [
    found
    for found in vars(plan).values()
    if isinstance(found, type) and issubclass(found, Frozen | Enum) and found.__module__.startswith(_MODULES)
]
_CLASSES: Final[Mapping[int, type[Frozen | Enum]]] = dict(
    enumerate(sorted(_DEFINED, key=lambda found: (found.__module__, found.__name__)), _FIRST_CLASS)
)
_NUMBERS: Final[Mapping[type, int]] = {cls: number for number, cls in _CLASSES.items()}
_FIELDS: Final = {bool, float, int, str, type(None)}  # of nodes
_FLOATS: Final = {"inf": inf, "-inf": -inf, "nan": nan}  # unsupported by JSON


class PlanDataError(Exception):
    """The data are not a plan, or the plan cannot be written as data."""


def _check_keys(keys: Iterable[object]) -> None:
    """Check that hashing and comparing keys neither calls methods of the plan nor recurses deeply.

    Raises:
        PlanDataError: A key has an unsupported class.
    """
    for key in keys:
        for part in key if type(key) is tuple else (key,):
            if type(part) not in _FIELDS and not isinstance(part, Enum):
                raise PlanDataError(f"unsupported key: {type(part).__name__}")


# ---------------------------------------------------------------- writing


def encode(root: object, files: Sequence[SourceFile]) -> str:
    """Encode a plan, or a container with a plan, as one line of JSON text.

    Args:
        root: The plan.
        files: The source files of its spans.

    Raises:
        PlanDataError: The plan contains a value of an unsupported class, a cycle, or a span of another file.
    """
    numbers: dict[int | tuple[int], int] = {}
    places = {id(file): number for number, file in enumerate(files)}
    table: list[list[Any]] = []
    for node in nodes(root):
        numbers[_key(node)] = len(table)
        table.append(_written(node, numbers, places))
    try:
        return json.dumps(table, separators=(",", ":"), allow_nan=False)
    except ValueError as error:
        raise PlanDataError("integer with thousands of digits") from error


def nodes(root: object) -> Iterator[object]:
    """Yield each node of a plan once, after the nodes that it refers to; the root is last.

    Raises:
        PlanDataError: A node has an unsupported class, or refers to itself.
    """
    found: set[int | tuple[int]] = set()
    opened: set[int] = set()
    stack = [root]
    while stack:
        node = stack[-1]
        missing = [part for part in _parts(node) if not (_is_plain(part) or _key(part) in found)]
        if missing and id(node) in opened:
            raise PlanDataError(f"a {type(node).__name__} refers to itself")
        opened.add(id(node))
        stack += reversed(missing)
        if not missing:
            stack.pop()
            if _key(node) not in found:
                found.add(_key(node))
                yield node


def _written(node: Any, numbers: Mapping[int | tuple[int], int], places: Mapping[int, int]) -> list[Any]:
    """Return a node as data.

    Args:
        node: The node.
        numbers: The numbers of all nodes before it, by their keys.
        places: The numbers of source files, by their identities.
    """
    cls = type(node)
    if cls is int:
        return [_INT, node]
    if cls is float:
        return [_FLOAT, str(node)]
    if cls is Span:
        if id(node.file) not in places:
            raise PlanDataError(f"a span of another file: {node.file.name}")
        return [_SPAN, places[id(node.file)], node.start, node.end]
    number = _CONTAINERS[cls] if cls in _CONTAINERS else _NUMBERS[cls]
    if isinstance(node, Enum):
        return [number, node.name]
    return [number, *(part if _is_plain(part) else numbers[_key(part)] for part in _parts(node))]


def _is_plain(value: object) -> bool:
    """Return whether JSON represents a value directly."""
    cls = type(value)
    return value is None or cls is str or cls is bool or (cls is float and isfinite(cast(float, value)))


def _key(value: object) -> int | tuple[int]:
    """Return the key of a node: its value for integers, its identity for all others."""
    return (value,) if type(value) is int else id(value)


def _parts(value: Any) -> Iterable[Any]:
    """Return the values that a node refers to.

    Raises:
        PlanDataError: Its class is unsupported.
    """
    cls = type(value)
    if cls in (int, float, Span) or (cls in _NUMBERS and isinstance(value, Enum)):
        return ()
    if cls in _NUMBERS:
        return [getattr(value, name) for name in value.__match_args__]
    if cls is dict:
        _check_keys(value)
        return [part for item in value.items() for part in item]
    if cls is frozenset:
        _check_keys(value)
        return sorted(value, key=repr)
    if cls is plan.Structures:
        return cast(plan.Structures, value).all()
    if cls is plan.Methods:
        return [part for (type_, name), method in value.items() for part in (type_, name, method)]
    if cls is tuple:
        return cast(tuple[Any, ...], value)
    raise PlanDataError(f"unsupported class: {cls.__name__}")


# ---------------------------------------------------------------- reading

_Maker: TypeAlias = Callable[[list[Any]], Any]


def decode(text: str, files: Sequence[SourceFile]) -> Any:
    """Decode the result of `encode`.

    Args:
        text: The JSON text.
        files: The source files, in the same order.

    Raises:
        PlanDataError: The text is invalid.
    """
    try:
        table = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise PlanDataError("invalid JSON") from error
    if type(table) is not list or not table:
        raise PlanDataError("empty table of nodes")
    made: dict[int, Any] = {}  # the nodes by number
    try:
        for number, node in enumerate(table):
            made[number] = _made(node, made, files)
    except KeyError as error:
        raise PlanDataError(f"unknown node: {error}") from error
    return made[len(table) - 1]


def _made(node: Any, made: Mapping[int, Any], files: Sequence[SourceFile]) -> Any:
    """Build a node from nodes that were built before.

    Raises:
        PlanDataError: It is invalid.
        KeyError: It refers to a node that was not built before.
    """
    if type(node) is not list or not node or not _FIELDS.issuperset(map(type, node)):
        raise PlanDataError("expected a node with a class and fields")
    number, *fields = node
    if type(number) is not int:
        raise PlanDataError("missing class of a node")
    if number == _SPAN:
        return _span(fields, files)
    if number in _LEAVES:
        return _LEAVES[number](fields)
    values = [made[field] if type(field) is int else field for field in fields]
    if number in _BRANCHES:
        return _BRANCHES[number](values)
    if number not in _CLASSES:
        raise PlanDataError(f"unknown class: {number}")
    cls = _CLASSES[number]
    if issubclass(cls, Enum):
        return _member(cls, values)
    if len(values) != len(cls.__match_args__):
        raise PlanDataError(f"expected {len(cls.__match_args__)} fields of {cls.__name__}, found {len(values)}")
    return cls(*values)


def _span(fields: list[Any], files: Sequence[SourceFile]) -> Span:
    if [type(field) for field in fields] != [int, int, int]:
        raise PlanDataError("expected a file, a start and an end of a span")
    number, start, end = fields
    if not (0 <= number < len(files) and 0 <= start <= end <= len(files[number].text)):
        raise PlanDataError("span outside of its file")
    return Span(files[number], start, end)


def _int(fields: list[Any]) -> int:
    if [type(field) for field in fields] != [int]:
        raise PlanDataError("invalid integer")
    return cast(int, fields[0])


def _float(fields: list[Any]) -> float:
    if len(fields) != 1 or type(fields[0]) is not str or fields[0] not in _FLOATS:
        raise PlanDataError("invalid float")
    return _FLOATS[fields[0]]


def _member(cls: type[Enum], values: list[Any]) -> Enum:
    if len(values) != 1 or type(values[0]) is not str or values[0] not in cls.__members__:
        raise PlanDataError(f"invalid {cls.__name__}")
    return cls.__members__[values[0]]


def _frozenset(values: list[Any]) -> frozenset[Any]:
    _check_keys(values)
    return frozenset(values)


def _dict(values: list[Any]) -> dict[Any, Any]:
    if len(values) % 2:
        raise PlanDataError("missing value of a key")
    keys = values[::2]
    _check_keys(keys)
    return dict(zip(keys, values[1::2], strict=True))


def _structures(values: list[Any]) -> plan.Structures:
    made = plan.Structures()
    for value in values:
        if not (isinstance(value, plan.Structure) and isinstance(value.type, plan.StructType | plan.ActorType)):
            raise PlanDataError("invalid structures")
        _check_keys([value.type.name])
        made.add(value)
    return made


def _methods(values: list[Any]) -> plan.Methods:
    made = plan.Methods()
    if len(values) % 3:
        raise PlanDataError("missing name of a method")
    for type_, name, method in zip(values[::3], values[1::3], values[2::3], strict=True):
        if not (type(type_) is type(name) is str and isinstance(method, plan.Method)):
            raise PlanDataError("invalid methods")
        made.add(type_, name, method)
    return made


_LEAVES: Final[Mapping[int, _Maker]] = {_INT: _int, _FLOAT: _float}
_BRANCHES: Final[Mapping[int, _Maker]] = {
    _TUPLE: tuple,
    _FROZENSET: _frozenset,
    _DICT: _dict,
    _STRUCTURES: _structures,
    _METHODS: _methods,
}
