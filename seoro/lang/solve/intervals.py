"""Interval arithmetic: ranges of results, and ranges of operands with given results.

Bounds of reals are rounded outward, so that they include all floats of the runtime. Integers are exact; results
outside of 64 bits are impossible, or wrap with `wrapping`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final, cast

from seoro.lang.arithmetic import INT_LIMITS, UINT_LIMITS, Number, calculate, divide_integers, wrap
from seoro.lang.solve.sets import REALS, Empty, Range, between
from seoro.lang.solve.terms import Operation

LIMITS: Final = {Number.INT: Range(*INT_LIMITS), Number.UINT: Range(*UINT_LIMITS), Number.FLOAT: REALS}


def combine(operation: Operation, left: Range, right: Range, number: Number, wrapping: bool) -> Range:
    """Return the range of results; for two single numbers, exactly the result of the runtime."""
    if left.low == left.high and right.low == right.high:
        try:
            exact = calculate(operation, left.low, right.low, number)
        except ZeroDivisionError:
            return LIMITS[number]  # the final evaluation reports it
        return REALS if math.isnan(exact) else Range(exact, exact)
    low, high = _bounds(operation, left, right, number)
    return _fitted(low, high, number, wrapping)


def negate(operand: Range, number: Number, wrapping: bool) -> Range:
    """Return a negated range; the function is its own inverse."""
    return converted(Range(-operand.high, -operand.low), number, wrapping)


def converted(operand: Range, number: Number, wrapping: bool) -> Range:
    """Convert a range between the integer types; the function is its own inverse."""
    if operand.low == operand.high:
        exact = wrap(operand.low, number)
        return Range(exact, exact)
    return _fitted(*operand, number, wrapping)


def split(
    operation: Operation, result: Range, left: Range, right: Range, number: Number, wrapping: bool
) -> tuple[Range, Range]:
    """Return the ranges of operands with a given range of results; they may be larger than before.

    Raises:
        Empty: No operands have such results.
    """
    out = Range(*_outward(*result)) if number is Number.FLOAT else result  # with reals that are rounded to it
    if operation in {"+", "-"}:  # these have inverses modulo 2**64, too
        first = _bounds("-" if operation == "+" else "+", out, right, number)
        second = _bounds("-", out, left, number) if operation == "+" else _bounds("-", left, out, number)
        return _fitted(*first, number, wrapping), _fitted(*second, number, wrapping)
    if operation == "*" and _is_exact(operation, left, right, number, wrapping):
        return _factor(out, left, right, number), _factor(out, right, left, number)
    if operation == "/" and number is Number.FLOAT:
        return _real_dividend(out, left, right), _divisor(out, left, right)
    if operation == "/" and (right.low, right.high) != (0, 0) and _is_exact("/", left, right, number, wrapping):
        return _dividend(out, right), right
    return left, right


def _is_exact(operation: Operation, left: Range, right: Range, number: Number, wrapping: bool) -> bool:
    """Return whether the result cannot wrap, or may not."""
    if number is Number.FLOAT or not wrapping:
        return True
    low, high = _bounds(operation, left, right, number)
    return low >= LIMITS[number].low and high <= LIMITS[number].high


def _fitted(low: float, high: float, number: Number, wrapping: bool) -> Range:
    """Fit the bounds of a result to its type."""
    limits = LIMITS[number]
    if number is Number.FLOAT or (low >= limits.low and high <= limits.high):
        return Range(low, high)
    if not wrapping:
        return between(max(low, limits.low), min(high, limits.high))
    wrapped = Range(wrap(low, number), wrap(high, number))
    if high - low >= 2**64 or wrapped.low > wrapped.high:
        return limits
    return wrapped


def _bounds(operation: Operation, left: Range, right: Range, number: Number) -> tuple[float, float]:
    """Return the bounds of a result before it is fitted to its type."""
    match operation:
        case "+":
            low, high = left.low + right.low, left.high + right.high
        case "-":
            low, high = left.low - right.high, left.high - right.low
        case "*":
            low, high = _corners(_times, left, right)
        case "/" if not right.low <= 0 <= right.high:
            low, high = _corners(_ratio if number is Number.FLOAT else divide_integers, left, right)
        case "/" if number is Number.FLOAT:
            return REALS
        case "/":
            high = max(abs(left.low), abs(left.high))
            return -high, high
        case "%":
            return _remainder(left, right, number)
    return _outward(low, high) if number is Number.FLOAT else (low, high)


def _corners(operation: Callable[[float, float], float], left: Range, right: Range) -> tuple[float, float]:
    """Return the least and the greatest result for the bounds of two ranges."""
    results = [operation(one, other) for one in left for other in right]
    return min(results), max(results)


def _times(one: float, other: float) -> float:
    """Return a product of bounds; an infinite bound times zero is zero, as all finite numbers are."""
    return 0 if one == 0 or other == 0 else one * other


def _ratio(one: float, other: float) -> float:
    """Return a quotient of bounds; two infinite ones result in zero, and another corner in the other end."""
    return 0.0 if math.isinf(one) and math.isinf(other) else one / other


def _remainder(left: Range, right: Range, number: Number) -> tuple[float, float]:
    """Return the bounds of a remainder: with the sign of the dividend, below the divisor, at most the dividend."""
    if number is Number.FLOAT and (right.low <= 0 <= right.high or math.isinf(left.low) or math.isinf(left.high)):
        return REALS  # the result may be nan
    most, zero = max(abs(right.low), abs(right.high)), wrap(0, number)
    if number is not Number.FLOAT:
        most = max(most - 1, 0)
    return max(-most, left.low) if left.low < 0 else zero, min(most, left.high) if left.high > 0 else zero


def _factor(out: Range, factor: Range, other: Range, number: Number) -> Range:
    """Return the range of a factor, given the product and the other factor."""
    if other.low <= 0 <= other.high:
        return factor
    if number is Number.FLOAT:
        return Range(*_bounds("/", out, other, number))
    low, high = cast(tuple[int, int], out)
    return _whole_factor(low, high, cast(int, other.low), cast(int, other.high))


def _whole_factor(low: int, high: int, first: int, last: int) -> Range:
    """Return the integers whose product with `first` to `last`, on one side of zero, is in `low` to `high`."""
    if last < 0:
        low, high, first, last = -high, -low, -last, -first
    # The smallest f with f * o >= low belongs to the largest o if low is positive, else to the smallest o.
    smallest = -(-low // (last if low > 0 else first))
    largest = high // (first if high > 0 else last)
    return between(smallest, largest)


def _dividend(out: Range, divisor: Range) -> Range:
    """Return the range of an integer dividend, given the truncated quotient."""
    most = cast(int, max(abs(divisor.low), abs(divisor.high)))
    low, high = cast(tuple[int, int], out)
    if divisor.low < 0:
        reach = max(abs(low), abs(high)) * most + most - 1
        return Range(-reach, reach)
    least = cast(int, max(divisor.low, 1))
    return between(
        low * (least if low > 0 else most) - (most - 1 if low <= 0 else 0),
        high * (most if high > 0 else least) + (most - 1 if high >= 0 else 0),
    )


def _real_dividend(out: Range, dividend: Range, divisor: Range) -> Range:
    """Return the range of a real dividend, given the quotient; unchanged if it may be infinite."""
    if divisor.low <= 0 <= divisor.high and (math.isinf(out.low) or math.isinf(out.high)):
        return dividend
    return Range(*_bounds("*", out, divisor, Number.FLOAT))


def _divisor(out: Range, dividend: Range, divisor: Range) -> Range:
    """Return the range of a real divisor, given the quotient; unchanged if that may be zero."""
    if out.low <= 0 <= out.high or dividend.low <= 0 <= dividend.high:
        return divisor
    return Range(*_bounds("/", dividend, out, Number.FLOAT))


def _outward(low: float, high: float) -> tuple[float, float]:
    """Extend bounds of reals by one float on each side; nan becomes infinite."""
    return (
        -math.inf if math.isnan(low) else math.nextafter(low, -math.inf),
        math.inf if math.isnan(high) else math.nextafter(high, math.inf),
    )


def square_root(result: Range, root: Range, number: Number) -> Range:
    """Return the range of square roots: of both signs, or of the sign of `root`."""
    if result.high < 0:
        raise Empty
    if number is Number.FLOAT:
        reach = math.nextafter(math.sqrt(math.nextafter(result.high, math.inf)), math.inf)
        least = math.nextafter(math.sqrt(max(math.nextafter(result.low, -math.inf), 0.0)), -math.inf)
    else:
        reach = math.isqrt(cast(int, result.high))
        least = math.isqrt(cast(int, result.low) - 1) + 1 if result.low > 0 else 0
    if root.low >= 0:
        return between(max(least, 0), reach)
    if root.high <= 0:
        return between(-reach, -max(least, 0))
    return between(-reach, reach)
