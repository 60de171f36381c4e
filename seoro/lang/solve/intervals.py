"""Arithmetic of ranges: what the result of an operation can be, and what its operands can have been.

Bounds of reals are rounded outward, so that no float that the runtime would compute is lost. Whole numbers are
exact; where a result leaves the 64 bits of its type, it is taken to be out of the question, or, with `wrapping`,
to wrap.
"""

from __future__ import annotations

import math
from typing import Final, cast

from seoro.lang.integers import INT_LIMITS, UINT_LIMITS
from seoro.lang.solve.evaluation import calculate, wrap
from seoro.lang.solve.sets import REALS, Empty, Range, between
from seoro.lang.solve.terms import Number, Operation, Unevaluable

_LIMITS: Final = {Number.INT: Range(*INT_LIMITS), Number.UINT: Range(*UINT_LIMITS), Number.FLOAT: REALS}


def combine(operation: Operation, left: Range, right: Range, number: Number, wrapping: bool) -> Range:
    """What an operation on two ranges can give; of two single numbers, exactly what the runtime computes."""
    if left.low == left.high and right.low == right.high:
        try:
            exact = calculate(operation, left.low, right.low, number)
        except Unevaluable:
            return _LIMITS[number]  # the evaluation in the end will say so
        return REALS if math.isnan(exact) else Range(exact, exact)
    low, high = _bounds(operation, left, right, number)
    return _fitted(low, high, number, wrapping)


def negate(operand: Range, number: Number, wrapping: bool) -> Range:
    """What minus a range can be; it is its own inverse."""
    if operand.low == operand.high:
        exact = wrap(-operand.low, number)
        return Range(exact, exact)
    return _fitted(-operand.high, -operand.low, number, wrapping)


def converted(operand: Range, number: Number, wrapping: bool) -> Range:
    """What whole numbers of the other kind are as `number`; it is its own inverse."""
    if operand.low == operand.high:
        exact = wrap(operand.low, number)
        return Range(exact, exact)
    return _fitted(*operand, number, wrapping)


def split(
    operation: Operation, result: Range, left: Range, right: Range, number: Number, wrapping: bool
) -> tuple[Range, Range]:
    """What the operands can have been, given what the result can be: ranges that may be larger than before.

    Raises:
        Empty: There are no such operands.
    """
    out = _rounded(result) if number is Number.FLOAT else result
    if operation == "+":
        return (
            _inverse(_bounds("-", out, right, number), number, wrapping),
            _inverse(_bounds("-", out, left, number), number, wrapping),
        )
    if operation == "-":
        return (
            _inverse(_bounds("+", out, right, number), number, wrapping),
            _inverse(_bounds("-", left, out, number), number, wrapping),
        )
    if operation == "*" and _is_exact(operation, left, right, number, wrapping):
        return _factor(out, left, right, number), _factor(out, right, left, number)
    if operation == "/" and number is Number.FLOAT:
        return _real_dividend(out, left, right), _divisor(out, left, right)
    if operation == "/" and (right.low, right.high) != (0, 0) and _is_exact("/", left, right, number, wrapping):
        return _dividend(out, right), right
    return left, right


def _is_exact(operation: Operation, left: Range, right: Range, number: Number, wrapping: bool) -> bool:
    """Whether the result cannot have wrapped, or is taken not to have."""
    if number is Number.FLOAT or not wrapping:
        return True
    low, high = _bounds(operation, left, right, number)
    return low >= _LIMITS[number].low and high <= _LIMITS[number].high


def _inverse(bounds: tuple[float, float], number: Number, wrapping: bool) -> Range:
    """An operand of a sum or difference: these can be undone modulo 2**64, too."""
    return _fitted(*bounds, number, wrapping)


def _fitted(low: float, high: float, number: Number, wrapping: bool) -> Range:
    """A result as its type holds it."""
    limits = _LIMITS[number]
    if number is Number.FLOAT or (low >= limits.low and high <= limits.high):
        return Range(low, high)
    if not wrapping:
        return between(max(low, limits.low), min(high, limits.high))
    wrapped = Range(wrap(low, number), wrap(high, number))
    if high - low >= 2**64 or wrapped.low > wrapped.high:
        return limits
    return wrapped


def _bounds(operation: Operation, left: Range, right: Range, number: Number) -> tuple[float, float]:
    """Bounds of a result before it is held by its type; `left` and `right` may be results themselves."""
    match operation:
        case "+":
            low, high = left.low + right.low, left.high + right.high
        case "-":
            low, high = left.low - right.high, left.high - right.low
        case "*":
            return _product(left, right, number)
        case "/":
            return _quotient(left, right, number)
        case "%":
            return _remainder(left, right, number)
    return _outward(low, high) if number is Number.FLOAT else (low, high)


def _product(left: Range, right: Range, number: Number) -> tuple[float, float]:
    corners = [_times(one, other) for one in left for other in right]
    low, high = min(corners), max(corners)
    return _outward(low, high) if number is Number.FLOAT else (low, high)


def _times(one: float, other: float) -> float:
    """A product of bounds; an infinite bound is as large as one likes, but no number: times zero it is zero."""
    return 0 if one == 0 or other == 0 else one * other


def _quotient(left: Range, right: Range, number: Number) -> tuple[float, float]:
    if right.low <= 0 <= right.high:
        if number is Number.FLOAT:
            return REALS
        most = max(abs(left.low), abs(left.high))
        return -most, most
    if number is Number.FLOAT:
        corners = [_ratio(one, other) for one in left for other in right]
        return _outward(min(corners), max(corners))
    exact = [_truncated(cast(int, one), cast(int, other)) for one in left for other in right]
    return min(exact), max(exact)


def _ratio(one: float, other: float) -> float:
    """A quotient of bounds; of two infinite ones anything from zero up, whose other end another corner has."""
    return 0.0 if math.isinf(one) and math.isinf(other) else one / other


def _truncated(one: int, other: int) -> int:
    quotient = abs(one) // abs(other)
    return quotient if (one < 0) == (other < 0) else -quotient


def _remainder(left: Range, right: Range, number: Number) -> tuple[float, float]:
    """A remainder has the sign of the dividend, is smaller than the divisor and no larger than the dividend."""
    if number is Number.FLOAT and (right.low <= 0 <= right.high or math.isinf(left.low) or math.isinf(left.high)):
        return REALS  # it may be no number
    most, zero = max(abs(right.low), abs(right.high)), wrap(0, number)
    if number is not Number.FLOAT:
        most = max(most - 1, 0)
    return max(-most, left.low) if left.low < 0 else zero, min(most, left.high) if left.high > 0 else zero


def _factor(out: Range, factor: Range, other: Range, number: Number) -> Range:
    """What a factor can have been, given the product and the other factor."""
    if other.low <= 0 <= other.high:
        return factor
    if number is Number.FLOAT:
        return Range(*_quotient(out, other, number))
    low, high = cast(tuple[int, int], out)
    return _whole_factor(low, high, cast(int, other.low), cast(int, other.high))


def _whole_factor(low: int, high: int, first: int, last: int) -> Range:
    """Whole numbers whose product with one from `first` to `last`, all on one side of zero, is in range."""
    if last < 0:
        low, high, first, last = -high, -low, -last, -first
    # f * o >= low has its smallest f with the largest o where low is positive, with the smallest one where not.
    smallest = -(-low // (last if low > 0 else first))
    largest = high // (first if high > 0 else last)
    return between(smallest, largest)


def _dividend(out: Range, divisor: Range) -> Range:
    """What was divided by a whole number, given the truncated quotient."""
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
    """What a real was divided by another, given the quotient; by zero, an infinite one says nothing."""
    if divisor.low <= 0 <= divisor.high and (math.isinf(out.low) or math.isinf(out.high)):
        return dividend
    return Range(*_product(out, divisor, Number.FLOAT))


def _divisor(out: Range, dividend: Range, divisor: Range) -> Range:
    """What a real was divided by, given the quotient; nothing is said where the quotient may be zero."""
    if out.low <= 0 <= out.high or dividend.low <= 0 <= dividend.high:
        return divisor
    return Range(*_quotient(dividend, out, Number.FLOAT))


def _rounded(result: Range) -> Range:
    """All reals that may have been rounded to a result."""
    return Range(*_outward(result.low, result.high))


def _outward(low: float, high: float) -> tuple[float, float]:
    """Bounds of reals, one float further apart on each side; what is no number bounds nothing."""
    return (
        -math.inf if math.isnan(low) else math.nextafter(low, -math.inf),
        math.inf if math.isnan(high) else math.nextafter(high, math.inf),
    )


def square_root(result: Range, root: Range, number: Number) -> Range:
    """What was multiplied by itself, given the square: a hull of both signs, or the one that `root` can have."""
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
