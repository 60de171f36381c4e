"""The two integer types: their limits, and how values wrap (7.3.2.2, 7.4.2.3.1); division of numbers."""

from __future__ import annotations

import math
from typing import Final

INT_LIMITS: Final = (-(2**63), 2**63 - 1)
UINT_LIMITS: Final = (0, 2**64 - 1)


def wrap_int(value: int) -> int:
    """Return the value in two's complement of 64 bits."""
    return (value + 2**63) % 2**64 - 2**63


def wrap_uint(value: int) -> int:
    """Return the value modulo 2**64."""
    return value % 2**64


def divide_integers(operator: str, left: float, right: float) -> float:
    """Return the quotient, truncated toward zero, or the remainder, with the sign of the dividend; unwrapped."""
    quotient = abs(int(left)) // abs(int(right))
    if (left < 0) != (right < 0):
        quotient = -quotient
    return quotient if operator == "/" else left - quotient * right


def divide_floats(operator: str, left: float, right: float) -> float:
    """Return the quotient or the remainder by IEEE 754, including division by zero."""
    if operator == "%":
        return math.nan if right == 0 or math.isinf(left) else math.fmod(left, right)
    if right != 0:
        return left / right
    if left == 0 or math.isnan(left):
        return math.nan
    return math.copysign(math.inf, left) * math.copysign(1.0, right)
