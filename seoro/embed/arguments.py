"""Checks of arguments of the Python API; errors at the call state the expected type."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from types import ModuleType
from typing import TypeAlias, TypeVar

from seoro.errors import UsageError
from seoro.robotics.tracks import MAX_POSE_RATE

AnyPath: TypeAlias = str | os.PathLike[str]
T = TypeVar("T")


def wrong_type(name: str, value: object, expected: str, help: str = "") -> UsageError:  # noqa: A002
    """Make the error for an argument of a wrong type."""
    shown = repr(value)
    shown = shown if len(shown) <= 60 else f"{shown[:57]}..."
    return UsageError(f"invalid `{name}`: expected {expected}, found {shown} ({type(value).__name__})", help=help)


def instance_of(kind: type[T], expected: str, help: str = "") -> Callable[[str, object], T]:  # noqa: A002
    """Make a check for instances of a class; a bool is not a number.

    Args:
        kind: The class.
        expected: Description of a valid value.
        help: Suggestion for a fix.
    """

    def check(name: str, value: object) -> T:
        if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
            raise wrong_type(name, value, expected, help)
        return value

    return check


def list_of(convert: Callable[[str, object], T], expected: str) -> Callable[[str, object], tuple[T, ...]]:
    """Make a conversion of iterables into tuples; a single text or path is not an iterable.

    Args:
        convert: Conversion of an item.
        expected: Description of a valid value.
    """

    def convert_all(name: str, value: object) -> tuple[T, ...]:
        if isinstance(value, str | os.PathLike) or not isinstance(value, Iterable):
            raise wrong_type(name, value, expected)
        return tuple(convert(f"{name}[{index}]", each) for index, each in enumerate(value))

    return convert_all


def to_path(name: str, value: object) -> Path:
    """Convert a `str` or `os.PathLike`.

    Raises:
        UsageError: `value` is neither.
    """
    if not isinstance(value, str | os.PathLike) or not isinstance(os.fspath(value), str):
        raise wrong_type(name, value, "a path (str or os.PathLike)")
    return Path(value)


to_text = instance_of(str, "a str")
to_flag = instance_of(bool, "True or False")
to_whole = instance_of(int, "a whole number (int)")
to_paths = list_of(to_path, "a list of paths")
to_texts = list_of(to_text, "a list of str")
to_modules = list_of(instance_of(ModuleType, "a module, which `import` returns"), "a list of modules")


def to_number(name: str, value: object) -> float:
    """Check an `int` or `float`, which may be infinite.

    Raises:
        UsageError: `value` is something else.
    """
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise wrong_type(name, value, "a number")
    return float(value)


def number_with(is_valid: Callable[[float], bool], expected: str) -> Callable[[str, object], float]:
    """Make a check of numbers, which may be infinite.

    Args:
        is_valid: Condition on a number.
        expected: Description of a valid number.
    """

    def check(name: str, value: object) -> float:
        number = to_number(name, value)
        if not is_valid(number):
            raise UsageError(f"invalid `{name}`: found {value!r}, expected {expected}")
        return number

    return check


to_limit = number_with(lambda limit: limit > 0.0, "seconds above 0")
to_pose_rate = number_with(lambda rate: 0.0 <= rate <= MAX_POSE_RATE, f"0 to {MAX_POSE_RATE:g} Hz")
to_wait = number_with(lambda wait: wait >= 0.0, "seconds from 0")
_to_rate = number_with(lambda rate: rate > 0.0, 'a number above 0 or "max"')


def to_rate(name: str, value: object) -> float:
    """Check simulated seconds per second; `"max"` is as fast as possible, as on the command line.

    Raises:
        UsageError: `value` is neither a number above 0 nor `"max"`.
    """
    if isinstance(value, str) and value != "max":
        raise wrong_type(name, value, 'a number or "max"')
    return math.inf if value == "max" else _to_rate(name, value)


def to_function(name: str, value: object) -> Callable[..., object]:
    """Check a function.

    Raises:
        UsageError: `value` cannot be called.
    """
    if not callable(value):
        raise wrong_type(name, value, "a function")
    return value


def to_overrides(name: str, value: object) -> dict[str, str]:
    """Convert values of parameters into expressions of the language.

    Args:
        name: Name of the argument.
        value: Values by the path of the parameter: a `str` is an expression; numbers, booleans and lists are
            converted.

    Raises:
        UsageError: `value` is not a mapping, or one of its values cannot be converted.
    """
    if not isinstance(value, Mapping):
        raise wrong_type(name, value, 'a mapping such as {"goal.x": "3m", "count": 2}')
    found = {}
    for path, each in value.items():
        key = to_text(f"a key of {name}", path)
        found[key] = each if isinstance(each, str) else _to_expression(each, f"{name}[{key!r}]")
    return found


def _to_expression(value: object, where: str) -> str:
    from seoro.embed.parameter_files import to_expression  # noqa: PLC0415 - seldom needed

    return to_expression(value, where)


def optional(convert: Callable[[str, object], T], name: str, value: object) -> T | None:
    """Convert a value unless it is `None`."""
    return None if value is None else convert(name, value)
