"""Dimensions and units (7.3.4): exponents of the SI base units and the radian, factor and offset."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final, TypeAlias

BASE_UNITS: Final = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
Dimension: TypeAlias = tuple[int, ...]  # exponents, in the order of BASE_UNITS
DIMENSIONLESS: Final[Dimension] = (0,) * len(BASE_UNITS)


def dimension(exponents: Mapping[str, int]) -> Dimension:
    """Return the dimension with the given exponents; others are zero."""
    return tuple(exponents.get(unit, 0) for unit in BASE_UNITS)


def product(left: Dimension, right: Dimension) -> Dimension:
    """Return the dimension of a product."""
    return tuple(a + b for a, b in zip(left, right, strict=True))


def quotient(left: Dimension, right: Dimension) -> Dimension:
    """Return the dimension of a quotient."""
    return tuple(a - b for a, b in zip(left, right, strict=True))


def unit_text(of: Dimension) -> str:
    """Return the SI unit of a dimension for people, such as `m/s` or `kg/m/s^2`."""
    above = [_power(unit, exponent) for unit, exponent in zip(BASE_UNITS, of, strict=True) if exponent > 0]
    below = [_power(unit, -exponent) for unit, exponent in zip(BASE_UNITS, of, strict=True) if exponent < 0]
    return "/".join(["*".join(above) or "1", *below])


def _power(unit: str, exponent: int) -> str:
    return unit if exponent == 1 else f"{unit}^{exponent}"


def to_si(value: float, factor: float, offset: float) -> float:
    """Convert a value in a unit to the base unit (7.3.4)."""
    return float(value) * factor + offset
