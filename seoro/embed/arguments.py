"""Checks of arguments of the Python API: a wrong type is refused at the call, with what was expected."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from types import ModuleType
from typing import TypeAlias, TypeVar

from seoro.errors import InvalidUse
from seoro.parameters import to_expression

AnyPath: TypeAlias = str | os.PathLike[str]
T = TypeVar("T")


def to_path(name: str, value: object) -> Path:
    """Convert a `str` or `os.PathLike`.

    Raises:
        InvalidUse: `value` is neither.
    """
    if not isinstance(value, str | os.PathLike) or not isinstance(os.fspath(value), str):
        raise wrong_type(name, value, "a path (str or os.PathLike)")
    return Path(value)


def to_paths(name: str, value: object) -> tuple[Path, ...]:
    """Convert an iterable of paths.

    Raises:
        InvalidUse: `value` is a single path, or something else.
    """
    if isinstance(value, str | os.PathLike) or not isinstance(value, Iterable):
        raise wrong_type(name, value, "a list of paths")
    return tuple(to_path(f"{name}[{index}]", each) for index, each in enumerate(value))


def to_text(name: str, value: object) -> str:
    """Check a `str`.

    Raises:
        InvalidUse: `value` is something else.
    """
    if not isinstance(value, str):
        raise wrong_type(name, value, "a str")
    return value


def to_number(name: str, value: object) -> float:
    """Check an `int` or `float`, which may be infinite.

    Raises:
        InvalidUse: `value` is something else.
    """
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise wrong_type(name, value, "a number")
    return float(value)


def to_limit(name: str, value: object) -> float:
    """Check a limit of time [s]: a number above 0, which may be infinite.

    Raises:
        InvalidUse: `value` is something else.
    """
    return _to_valid(name, value, lambda limit: limit > 0.0, "seconds above 0")


def to_wait(name: str, value: object) -> float:
    """Check a time to wait [s]: a number from 0, which may be infinite.

    Raises:
        InvalidUse: `value` is something else.
    """
    return _to_valid(name, value, lambda wait: wait >= 0.0, "seconds from 0")


def to_rate(name: str, value: object) -> float:
    """Check simulated seconds per second; `"max"` is as fast as possible, as on the command line.

    Raises:
        InvalidUse: `value` is neither a number above 0 nor `"max"`.
    """
    if isinstance(value, str) and value == "max":
        return math.inf
    if isinstance(value, str):
        raise wrong_type(name, value, 'a number or "max"')
    return _to_valid(name, value, lambda rate: rate > 0.0, 'a number above 0 or "max"')


def _to_valid(name: str, value: object, is_valid: Callable[[float], bool], expected: str) -> float:
    number = to_number(name, value)
    if not is_valid(number):
        raise InvalidUse(f"invalid `{name}`: found {value!r}, expected {expected}")
    return number


def to_flag(name: str, value: object) -> bool:
    """Check a `bool`.

    Raises:
        InvalidUse: `value` is something else.
    """
    if not isinstance(value, bool):
        raise wrong_type(name, value, "True or False")
    return value


def to_texts(name: str, value: object) -> tuple[str, ...]:
    """Convert an iterable of `str`.

    Raises:
        InvalidUse: `value` is a single `str`, or something else.
    """
    if isinstance(value, str) or not isinstance(value, Iterable):
        raise wrong_type(name, value, "a list of str")
    return tuple(to_text(f"{name}[{index}]", each) for index, each in enumerate(value))


def to_modules(name: str, value: object) -> tuple[ModuleType, ...]:
    """Convert an iterable of Python modules.

    Raises:
        InvalidUse: `value` is a single module, or something else.
    """
    if not isinstance(value, Iterable) or isinstance(value, str):
        raise wrong_type(name, value, "a list of modules")
    found = tuple(value)
    for index, each in enumerate(found):
        if not isinstance(each, ModuleType):
            raise wrong_type(f"{name}[{index}]", each, "a module, which `import` returns")
    return found


def to_function(name: str, value: object) -> Callable[..., object]:
    """Check a function.

    Raises:
        InvalidUse: `value` cannot be called.
    """
    if not callable(value):
        raise wrong_type(name, value, "a function")
    return value


def to_whole(name: str, value: object) -> int:
    """Check an `int`.

    Raises:
        InvalidUse: `value` is something else.
    """
    if isinstance(value, bool) or not isinstance(value, int):
        raise wrong_type(name, value, "a whole number (int)")
    return value


def to_overrides(name: str, value: object) -> dict[str, str]:
    """Convert values of parameters into expressions of the language.

    Args:
        name: Name of the argument.
        value: Values by the path of the parameter: a `str` is an expression; numbers, booleans and lists are
            converted.

    Raises:
        InvalidUse: `value` is not a mapping, or one of its values cannot be converted.
    """
    if not isinstance(value, Mapping):
        raise wrong_type(name, value, 'a mapping such as {"goal.x": "3m", "count": 2}')
    found = {}
    for path, each in value.items():
        key = to_text(f"a key of {name}", path)
        found[key] = each if isinstance(each, str) else to_expression(each, f"{name}[{key!r}]")
    return found


def optional(convert: Callable[[str, object], T], name: str, value: object) -> T | None:
    """Convert a value that may be None."""
    return None if value is None else convert(name, value)


def instance_of(kind: type[T], example: str) -> Callable[[str, object], T]:
    """Make a check for instances of a class.

    Args:
        kind: The class.
        example: An expression that makes one, for messages.
    """

    def check(name: str, value: object) -> T:
        if not isinstance(value, kind):
            raise wrong_type(name, value, f"a seoro.{kind.__name__}", f"for example {example}")
        return value

    return check


def wrong_type(name: str, value: object, expected: str, help: str = "") -> InvalidUse:  # noqa: A002
    """Make the error for an argument of a wrong type."""
    shown = repr(value)
    shown = shown if len(shown) <= 60 else f"{shown[:57]}..."
    return InvalidUse(f"invalid `{name}`: expected {expected}, found {shown} ({type(value).__name__})", help=help)
