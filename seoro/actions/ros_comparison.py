"""Comparison of message values with the values that a scenario expects."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from enum import Enum
from itertools import islice
from typing import Any

from seoro.actions.ros_structs import of_struct
from seoro.actions.ros_support import read, shown
from seoro.errors import ActionFailed
from seoro.runtime.values.comparison import RELATIONS
from seoro.runtime.values.values import Struct

CLOSE = 1e-6  # relative tolerance of numbers: a `float32` has seven digits
TEXT_AS_IT_IS = "with `eval_expected_value: false` the expected value is a plain text"
MOST_DIFFERENCES = 5  # shown in messages


class Operator(Enum):
    """The enumeration `comparison_operator`."""

    lt = "<"
    le = "<="
    eq = "=="
    ne = "!="
    ge = ">="
    gt = ">"


def read_expected(value: object, *, is_text: bool) -> Any:
    """Return the expected value: a struct, a number, a boolean, or the value that a text contains.

    Args:
        value: Value of the parameter.
        is_text: Whether a text is expected literally, without parsing.

    Raises:
        ActionFailed: The text is invalid.
    """
    if isinstance(value, Struct):
        return of_struct(value)
    if not isinstance(value, str) or is_text:
        return value
    found = read(value, "`expected_value`")
    return "" if found is None else found  # an empty text parses as None


def compares(actual: Any, operator: Operator, expected: Any, what: str) -> bool:
    """Whether a received value satisfies a comparison with the expected one.

    Of structures, only the expected members are compared.

    Raises:
        ActionFailed: The values have no order, or can never be equal.
    """
    if operator in (Operator.eq, Operator.ne):
        if misfit := _misfit(actual, expected):
            raise ActionFailed(f"{what}: {misfit}")
        return (next(differences(actual, expected), None) is None) is (operator is Operator.eq)
    try:
        if _are_numbers(actual, expected) and _is_equal(actual, expected):
            return operator in (Operator.le, Operator.ge)
        return RELATIONS[operator.value](actual, expected)
    except TypeError:
        raise ActionFailed(
            f"cannot compare {what}: `{shown(actual)}` has no order with `{shown(expected)}`"
        ) from None


def difference(actual: Any, operator: Operator, expected: Any) -> str:
    """Describe why the comparison is false, as a predicate of the compared value."""
    if operator is not Operator.eq:
        return f"is `{shown(actual)}`; expected {operator.value} `{shown(expected)}`"
    found = list(islice(differences(actual, expected), MOST_DIFFERENCES + 1))
    lines = [f"{f'`{path}`: ' if path else ''}expected `{shown(b)}`, got `{shown(a)}`" for path, a, b in found]
    if len(lines) > MOST_DIFFERENCES:
        lines[-1] = "and more"
    return f"differs: {'; '.join(lines)}"


def differences(actual: Any, expected: Any, path: str = "") -> Iterator[tuple[str, Any, Any]]:
    """Yield differences of comparable values: path of a member, its value, and the expected value."""
    match actual, expected:
        case Mapping(), "":
            return  # no member is expected
        case Mapping(), Mapping():
            for name, value in expected.items():
                yield from differences(actual[name], value, f"{path}.{name}" if path else str(name))
        case list(), list() if len(actual) == len(expected):
            for place, pair in enumerate(zip(actual, expected, strict=True)):
                yield from differences(*pair, f"{path}.{place}" if path else str(place))
        case _:
            if not _is_equal(actual, expected):
                yield path, actual, expected


def _misfit(actual: Any, expected: Any, path: str = "") -> str:
    """Describe why two values can never be equal; empty if they can be."""
    match actual, expected:
        case Mapping(), "":
            return ""
        case Mapping(), Mapping():
            for name, value in expected.items():
                within = f"{path}.{name}" if path else str(name)
                if name not in actual:
                    return f"unknown member `{within}` (members: {', '.join(map(str, actual))})"
                if misfit := _misfit(actual[name], value, within):
                    return misfit
        case list(), list():
            pairs = enumerate(zip(actual, expected, strict=False))
            return next(filter(None, (_misfit(*pair, f"{path}.{i}" if path else str(i)) for i, pair in pairs)), "")
        case _ if _kind(actual) != _kind(expected):
            never = f"{f'`{path}`' if path else 'it'} is {_kind(actual)} and never equals {_kind(expected)}"
            hint = f"; {TEXT_AS_IT_IS}" if isinstance(actual, str) else ""
            return f"{never}, `{shown(expected)}`{hint}"
    return ""


def _kind(value: Any) -> str:
    match value:
        case bool():
            return "a boolean"
        case int() | float():
            return "a number"
        case str():
            return "a string"
        case list():
            return "a list"
        case Mapping():
            return "a structure"
        case _:
            return "nothing"


def _are_numbers(*values: Any) -> bool:
    return all(isinstance(value, int | float) and not isinstance(value, bool) for value in values)


def _is_equal(actual: Any, expected: Any) -> bool:
    if not _are_numbers(actual, expected):
        return type(actual) is type(expected) and bool(actual == expected)
    if isinstance(actual, int) and isinstance(expected, int):
        return bool(actual == expected)
    return math.isclose(actual, expected, rel_tol=CLOSE, abs_tol=CLOSE * CLOSE)
