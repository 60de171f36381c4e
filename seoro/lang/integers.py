"""The two integer types: their limits, and how values wrap (7.3.2.2, 7.4.2.3.1)."""

from __future__ import annotations

from typing import Final

INT_LIMITS: Final = (-(2**63), 2**63 - 1)
UINT_LIMITS: Final = (0, 2**64 - 1)


def wrap_int(value: int) -> int:
    """Return the value in two's complement of 64 bits."""
    return (value + 2**63) % 2**64 - 2**63


def wrap_uint(value: int) -> int:
    """Return the value modulo 2**64."""
    return value % 2**64
