"""Arithmetic of numbers: their types, the limits of integers, and operations (7.3.2.2, 7.4.2.3).

Integers have 64 bits and wrap; `int / int` truncates toward zero; `%` takes the sign of the dividend. Floats
follow IEEE 754, including division by zero.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping
from enum import Enum
from typing import Final, assert_never

INT_LIMITS: Final = (-(2**63), 2**63 - 1)
UINT_LIMITS: Final = (0, 2**64 - 1)


class Number(Enum):
    """Type of the operands and the result of an operation (7.4.2.3.1); physical values are floats."""

    INT = "int"
    UINT = "uint"
    FLOAT = "float"


_EXACT: Final[Mapping[str, Callable[[float, float], float]]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
}


def wrap(value: float, number: Number) -> int | float:
    """Convert a number to a type; integers wrap in two's complement of 64 bits, or modulo 2**64."""
    match number:
        case Number.INT:
            return (int(value) + 2**63) % 2**64 - 2**63
        case Number.UINT:
            return int(value) % 2**64
        case Number.FLOAT:
            return float(value)
        case _:
            assert_never(number)


def calculate(operation: str, left: float, right: float, number: Number) -> int | float:
    """Return the result of `+`, `-`, `*`, `/` or `%` on two numbers.

    Raises:
        ZeroDivisionError: An integer is divided by zero.
    """
    if operation not in "/%":
        return wrap(_EXACT[operation](left, right), number)
    if number is Number.FLOAT:
        return _divide_floats(operation, float(left), float(right))
    quotient = divide_integers(left, right)
    return wrap(quotient if operation == "/" else left - quotient * right, number)


def divide_integers(left: float, right: float) -> int:
    """Return the quotient of integers, truncated toward zero, without wrapping."""
    quotient = abs(int(left)) // abs(int(right))
    return quotient if (left < 0) == (right < 0) else -quotient


def _divide_floats(operation: str, left: float, right: float) -> float:
    """Return the quotient or the remainder by IEEE 754, including division by zero."""
    if operation == "%":
        return math.nan if right == 0 or math.isinf(left) else math.fmod(left, right)
    if right != 0:
        return left / right
    if left == 0 or math.isnan(left):
        return math.nan
    return math.copysign(math.inf, left) * math.copysign(1.0, right)
