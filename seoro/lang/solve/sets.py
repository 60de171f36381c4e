"""Sets of possible values of cells and terms.

A range of two ints contains integers; a range of floats contains reals. Sets are never empty: operations raise
`Empty` instead.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final, NamedTuple, TypeAlias, cast

from seoro.lang.solve.terms import Boolean, Cell, Choice, Free, Integer, Real, Value

# Limit of the size of integer ranges that can become a list of values, without some in the middle.
SMALL: Final = 256
# Width of integer ranges of which a bound is a limit of the type.
HUGE: Final = 2**62
# Width of real ranges that are only rounding: relative, and absolute near zero.
NARROW: Final = 1e-12
TINY: Final = 1e-15


class Empty(Exception):
    """A set would be empty."""


class Range(NamedTuple):
    """All numbers from low to high, both included."""

    low: int | float
    high: int | float


class Finite(NamedTuple):
    """A few values, each once."""

    values: tuple[Value, ...]


class Anything(NamedTuple):
    """Any value."""


class Missing(NamedTuple):
    """Placeholder of a missing value."""


ValueSet: TypeAlias = Range | Finite | Anything

ANYTHING: Final = Anything()
MISSING: Final = Missing()
TRUE: Final = Finite((True,))
FALSE: Final = Finite((False,))
EITHER: Final = Finite((False, True))
REALS: Final = Range(-math.inf, math.inf)


def natural(cell: Cell) -> ValueSet:
    """Return the set of the domain of a cell."""
    match cell.domain:
        case Boolean():
            return EITHER
        case Choice(values):
            return Finite(values)
        case Integer(low, high):
            return Range(low, high)
        case Real(low, high):
            return Range(float(low), float(high))
        case Free():
            return ANYTHING


def without_bounds(cell: Cell) -> ValueSet:
    """Return the set of the domain of a cell without bounds."""
    match cell.domain:
        case Boolean():
            return EITHER
        case Choice() | Free():
            return ANYTHING
        case Integer():
            return Range(-(2**80), 2**80)
        case Real():
            return REALS


def single(value: Value) -> ValueSet:
    """Return the set of one value."""
    if isinstance(value, bool):
        return TRUE if value else FALSE
    if isinstance(value, int | float):
        return ANYTHING if value != value else Range(value, value)  # noqa: PLR0124 - no range holds a NaN
    return Finite((value,))


def only(values: ValueSet) -> Value | Missing:
    """Return the only value of a set, or `MISSING` if it has several."""
    if isinstance(values, Range):
        return values.low if values.low == values.high else MISSING
    if isinstance(values, Finite) and len(values.values) == 1:
        return values.values[0]
    return MISSING


def contains(values: ValueSet, value: Value) -> bool:
    """Return whether a set contains a value."""
    match values:
        case Range(low, high):
            return low <= cast(float, value) <= high
        case Finite(members):
            return value in members
        case Anything():
            return True


def hull(values: ValueSet) -> Range:
    """Return the smallest range that contains a set of numbers."""
    match values:
        case Range():
            return values
        case Finite(members):
            numbers = cast(tuple[float, ...], members)
            return Range(min(numbers), max(numbers))
        case Anything():
            return REALS


def is_whole(values: Range) -> bool:
    """Return whether a range contains integers."""
    return isinstance(values.low, int) and isinstance(values.high, int)


def members(values: ValueSet, most: int = SMALL) -> tuple[Value, ...] | None:
    """Return the values of a set; None for more than `most` values."""
    if isinstance(values, Finite):
        return values.values if len(values.values) <= most else None
    if isinstance(values, Range) and is_whole(values) and values.high - values.low < most:
        return tuple(range(cast(int, values.low), cast(int, values.high) + 1))
    return None


def between(low: float, high: float) -> Range:
    """Create a range from computed bounds."""
    if low > high:
        raise Empty
    return Range(low, high)


def filtered(values: tuple[Value, ...], keep: Callable[[Value], bool]) -> Finite:
    """Return the values for which `keep` is true."""
    kept = tuple(value for value in values if keep(value))
    if not kept:
        raise Empty
    return Finite(kept)


def meet(one: ValueSet, other: ValueSet) -> ValueSet:
    """Return the intersection of two sets, with the type of number and the order of the first."""
    if isinstance(other, Anything) or one is other:
        return one
    match one:
        case Anything():
            return other
        case Finite(values):
            kept = filtered(values, lambda value: contains(other, value))
            return one if len(kept.values) == len(values) else kept
        case Range(low, high):
            if isinstance(other, Finite):
                return filtered(other.values, lambda value: low <= cast(float, value) <= high)
            return _overlap(one, other)


def _overlap(one: Range, other: Range) -> Range:
    low, high = other
    if isinstance(one.low, int):
        if isinstance(low, float):
            low = math.ceil(low) if math.isfinite(low) else one.low
        if isinstance(high, float):
            high = math.floor(high) if math.isfinite(high) else one.high
    if low <= one.low and high >= one.high:
        return one
    return between(max(one.low, low), min(one.high, high))


def union(one: ValueSet, other: ValueSet) -> ValueSet:
    """Return a set that contains both sets."""
    if isinstance(one, Finite) and isinstance(other, Finite):
        return Finite((*one.values, *(value for value in other.values if value not in one.values)))
    if isinstance(one, Anything) or isinstance(other, Anything):
        return ANYTHING
    first, second = hull(one), hull(other)
    return Range(min(first.low, second.low), max(first.high, second.high))


def without(values: ValueSet, value: Value) -> ValueSet:
    """Remove a value from a set, if the result is a set of these kinds."""
    if not isinstance(values, Range):
        return filtered(values.values, lambda member: member != value) if isinstance(values, Finite) else values
    low, high = values
    number = cast(float, value)
    if not low <= number <= high:
        return values
    if low == high:
        raise Empty
    if not is_whole(values):
        return values  # a single real is never drawn
    if number == low:
        return Range(low + 1, high)
    if number == high:
        return Range(low, high - 1)
    listed = members(values)
    return values if listed is None else filtered(listed, lambda member: member != value)


def is_narrow(values: ValueSet) -> bool:
    """Return whether a range of reals is only rounding of one number."""
    if not isinstance(values, Range) or is_whole(values):
        return False
    width = values.high - values.low
    return width <= max(NARROW * max(abs(values.low), abs(values.high)), TINY)


def is_bounded(values: ValueSet) -> bool:
    """Return whether a value can be drawn from a set."""
    match values:
        case Range(low, high):
            return high - low < HUGE if is_whole(values) else math.isfinite(low) and math.isfinite(high)
        case Finite():
            return True
        case Anything():
            return False
